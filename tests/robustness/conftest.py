"""What the tests of this folder need in Blender."""

import pytest


@pytest.fixture
def block(scene):
    """The active object: a small block with a picture, the extension registered."""
    import bpy
    import dualcolor
    from dualcolor.bridge.units import use_millimeters

    dualcolor.register()
    use_millimeters(scene)
    bpy.ops.mesh.primitive_cube_add(size=6)
    made = bpy.context.object
    made.scale.z = 0.2
    image = bpy.data.images.new("picture", 8, 8)
    image.generated_color = (1, 1, 1, 1)
    made.dualcolor.image = image
    bpy.context.view_layer.update()
    yield made
    dualcolor.unregister()

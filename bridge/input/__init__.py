"""From Blender to the job's input: objects, materials, pictures, support volumes, model files."""

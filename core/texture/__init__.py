"""From pictures to the tone of every contour point (paper, section 4.1).

- Pixels to tones: `decode.py`, with `exif_orientation.py`, `image_size.py` and `grade.py` for what comes from files.
- The UV map, whatever the pictures show: `islands.py` finds which faces form one chart, `chart_edges.py` and
  `labels.py` which texels each covers; `charts.py` holds both. `uv_fit.py` tells whether the map can hold a picture of
  the whole surface.
- Filters: `island_levels.py` and `pyramid.py` make mip maps that keep islands apart, `lanczos.py` reduces a picture.
- `lookup.py` reads the tone at points of faces.
"""

"""A first image: a bone and a vessel in muscle, seen by a linear array."""
import insonify as us
from insonify import mm, MHz, tissue

body = us.scene(tissue.muscle)
body.add(us.make_sphere((6 * mm, 0, 30 * mm), 8 * mm), tissue.bone, name="bone")
body.add(us.make_cylinder((-9 * mm, -30 * mm, 17 * mm), (-9 * mm, 30 * mm, 17 * mm), 4 * mm), tissue.blood, name="vein")
body.build()
probe = us.linear_array(lines=192, frequency=7.5 * MHz)
picture = us.b_mode(body, probe, us.pose(), us.b_mode_settings(depth=50 * mm))
us.write_png("ten_lines.png", picture)  # picture.pixels is a numpy array of rows x columns

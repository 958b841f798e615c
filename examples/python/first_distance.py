"""How far apart are a ball and a tilted box?"""

import numpy as np
import tandem

ball = tandem.Sphere(0.5)
box = tandem.Box([1, 1, 1])
half = np.radians(45) / 2
tilted = [2, 0, 0, np.cos(half), 0, 0, np.sin(half)]  # where it is, then a unit quaternion w, x, y, z

answer = tandem.distance(ball, None, box, tilted)
print(f"gap {answer.signed_distance:.6f} m, from {answer.point_a} to {answer.point_b}")

deep = tandem.distance(ball, [1.5, 0, 0, 1, 0, 0, 0], box, tilted)
print(f"overlap {-deep.signed_distance:.6f} m, freed by a push along {deep.normal}")

"""Collision detection on many cores: distances, contacts, steps of whole scenes, batches of a planner.

Lengths are metres. Poses are (4, 4) homogeneous matrices, or (7,): translation, then unit quaternion w, x, y, z.
Errors are ValueError with what is wrong, where, and what is allowed.
"""

import numpy as _numpy  # noqa: F401  # first: the compiled part cannot say that it is missing

from ._tandem import *  # noqa: F401,F403
from ._tandem import __version__ as __version__
from .collision_manager import CollisionManager as CollisionManager
from .collision_manager import ContactData as ContactData
from .collision_manager import DistanceData as DistanceData
from .page import Page as Page
from .page import show as show

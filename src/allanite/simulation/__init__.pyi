from . import faults as faults
from .ring_laser import GL1 as GL1
from .ring_laser import RingLaser as RingLaser
from .ring_laser import simulate_ring_laser as simulate_ring_laser

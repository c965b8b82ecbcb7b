from . import faults as faults
from .record import GL1 as GL1
from .record import RingLaser as RingLaser
from .record import simulate_ring_laser as simulate_ring_laser

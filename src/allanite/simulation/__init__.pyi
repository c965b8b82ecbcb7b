from . import faults as faults
from .record import GL1 as GL1, RingLaser as RingLaser, simulate_ring_laser as simulate_ring_laser

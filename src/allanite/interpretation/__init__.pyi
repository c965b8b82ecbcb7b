from .devices import DEVICES as DEVICES
from .sentences import Meaning as Meaning

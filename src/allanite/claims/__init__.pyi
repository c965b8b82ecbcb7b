from .claim import ClaimedNoise as ClaimedNoise, claim_of as claim_of
from .drift_settings import DriftSettings as DriftSettings
from .result import ClaimCheck as ClaimCheck

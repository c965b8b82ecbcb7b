from .exports import EXPORTS as EXPORTS
from .imported import Imported as Imported
from .temperature import temperature_parameters as temperature_parameters

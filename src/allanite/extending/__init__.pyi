from allanite.core.aliases import constructed as constructed, public as public, size_and_rate as size_and_rate
from allanite.core.arrays import (
    LARGEST as LARGEST,
    BoolArray as BoolArray,
    FloatArray as FloatArray,
    IntArray as IntArray,
    stretches as stretches,
)
from allanite.core.choices import (
    DURATION as DURATION,
    INSTANT as INSTANT,
    MODEL as MODEL,
    Choices as Choices,
    choice as choice,
    described as described,
    separated as separated,
)
from allanite.core.correction import Correction as Correction
from allanite.core.curve import Curve as Curve
from allanite.core.encoding import finite as finite, plain as plain, read_key as read_key, write_plain as write_plain
from allanite.core.errors import (
    AllaniteError as AllaniteError,
    DataError as DataError,
    UnitError as UnitError,
    UsageError as UsageError,
    given as given,
)
from allanite.core.estimate import Estimate as Estimate
from allanite.core.files import write as write
from allanite.core.fit import Fit as Fit, chance as chance
from allanite.core.kinds import KINDS as KINDS
from allanite.core.limits import NormalMixture as NormalMixture, demand_level as demand_level
from allanite.core.model import (
    Model as Model,
    ModelLike as ModelLike,
    Term as Term,
    coefficient_factor as coefficient_factor,
    usable_model as usable_model,
)
from allanite.core.names import demand_name as demand_name, row_of as row_of
from allanite.core.plain import (
    Header as Header,
    Value as Value,
    header_from as header_from,
    stored_fields as stored_fields,
)
from allanite.core.ranges import (
    ANGLE as ANGLE,
    LATITUDE as LATITUDE,
    POSITIVE as POSITIVE,
    REAL as REAL,
    SAMPLES as SAMPLES,
    SHARE as SHARE,
    SIZE as SIZE,
    STAMP as STAMP,
    TIME as TIME,
    Range as Range,
)
from allanite.core.record import (
    SHORTEST as SHORTEST,
    Record as Record,
    Recording as Recording,
    Samples as Samples,
    Sampling as Sampling,
    as_record as as_record,
    header_dict as header_dict,
)
from allanite.core.syntax import split_quantities as split_quantities, written as written
from allanite.core.units import Signal as Signal, convert as convert, signal_with as signal_with, unit_of as unit_of
from allanite.core.validity import Finding as Finding, Quality as Quality
from allanite.identification.likelihood.likelihood import Likelihood as Likelihood
from allanite.identification.likelihood.spectrum import spectrum as spectrum
from allanite.identification.likelihood.whittle import likelihood as likelihood
from allanite.identification.methods import automatic as automatic
from allanite.phrases.phrase import (
    Phrase as Phrase,
    between as between,
    join as join,
    plural as plural,
    say as say,
    say_count as say_count,
    spelled as spelled,
    windowing as windowing,
)
from allanite.prepare import block_means as block_means, inspect as inspect, trim as trim
from allanite.prepare.rounding import NO_DITHER as NO_DITHER, rounding as rounding
from allanite.prepare.view import View as View
from allanite.readers import read as read
from allanite.simulation.record import readout_noise as readout_noise, simulate as simulate
from allanite.statistics import deviation as deviation
from allanite.statistics.moments.gls import Covariance as Covariance
from allanite.study.channels import (
    Inspected as Inspected,
    Progress as Progress,
    Source as Source,
    each_channel as each_channel,
    open_recording as open_recording,
    run as run,
    run_together as run_together,
    whole_recording as whole_recording,
)
from allanite.study.job import Job as Job, provenance_of as provenance_of
from allanite.study.noise import noise_of as noise_of
from allanite.study.recipe import READING as READING, Recipe as Recipe, chosen as chosen
from allanite.study.results import (
    ChannelResult as ChannelResult,
    Noise as Noise,
    RecordResult as RecordResult,
    noise_dict as noise_dict,
    noise_from as noise_from,
)
from allanite.terms import TERMS as TERMS

from .angle import (
    plot_angles as plot_angles,
    plot_error_in_time as plot_error_in_time,
    plot_errors as plot_errors,
    plot_history as plot_history,
    plot_innovations as plot_innovations,
    plot_optima as plot_optima,
    plot_scan as plot_scan,
    plot_scenarios as plot_scenarios,
)
from .applications import (
    plot_budgets as plot_budgets,
    plot_closeups as plot_closeups,
    plot_compensated as plot_compensated,
    plot_rates as plot_rates,
)
from .comparison import (
    Course as Course,
    LimitLine as LimitLine,
    LotRow as LotRow,
    UnitCurve as UnitCurve,
    plot_comparison as plot_comparison,
    plot_lot as plot_lot,
    plot_units as plot_units,
)
from .curves import plot_overlay as plot_overlay, plot_panels as plot_panels, plot_spectra as plot_spectra
from .models import (
    plot_claims as plot_claims,
    plot_drifts as plot_drifts,
    plot_plans as plot_plans,
    plot_state_spaces as plot_state_spaces,
    plot_stated as plot_stated,
)
from .panels import CurvePanel as CurvePanel, facts_of as facts_of, panels_of as panels_of
from .record import (
    plot_goodness as plot_goodness,
    plot_records as plot_records,
    plot_residuals as plot_residuals,
    plot_series as plot_series,
    plot_strip as plot_strip,
    plot_surfaces as plot_surfaces,
)

"""What is asked and what is kept, as schemas: the one is refused at the door, the other set aside by its name."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, NonNegativeInt, TypeAdapter, ValidationError
from pydantic_core import from_json
from typing_extensions import TypedDict

from allanite.cli.streams import complain
from allanite.core.errors import UsageError
from allanite.core.files import reason
from allanite.core.names import demand_name
from allanite.reporting.language import LANGUAGES

MAX_DEPTH = 50  # how deep a request is nested at most
MAX_KEPT_DEPTH = 60  # how deep a file is that is kept at most: a few levels more than the requests in it


def _spoken(lang: str) -> str:
    if lang:
        demand_name("language", lang, LANGUAGES)
    return lang


Id = Annotated[str, Field(pattern=r"^[0-9a-f]{16}-[0-9a-f]{16}$")]
Lang = Annotated[str, AfterValidator(_spoken)]
"""A language that the page speaks; empty for the one of the job or of the page."""


class Body(BaseModel):
    """The body of a request."""

    model_config = ConfigDict(extra="forbid")


class JobBody(Body):
    """A job: ids of its files or the address of a stream, and choices."""

    verb: str
    files: list[str] = []
    recipe: dict[str, Any] = {}
    target: str = ""
    lang: Lang = ""


class RefitBody(Body):
    """A channel with other choices, and the statistics whose curves are shown."""

    channel: str
    statistics: list[str] = []
    lang: Lang = ""
    terms: Any = None
    band: Any = None
    method: Any = None
    level: Any = None
    outliers: Any = None


class ExportBody(Body):
    """A target, the noise of other sensors, and besides the choices of an export."""

    model_config = ConfigDict(extra="allow")
    target: str
    channels: list[str] = []
    form: str = ""
    models: list[str] = []
    lang: Lang = ""


class PathBody(Body):
    """A file of this machine."""

    path: str


class ExampleBody(Body):
    """A recording to play with."""

    name: str = ""


class Kept(TypedDict):
    """What is kept; what another version of allanite has written beside it stays."""

    __pydantic_config__ = ConfigDict(extra="allow")  # type: ignore[misc]


class File(Kept):
    """A file of a workspace; `own` is one that was uploaded."""

    id: Id
    name: str
    bytes: NonNegativeInt
    path: str
    own: bool


class Problem(Kept):
    """Why a job failed."""

    error: str
    option: str | None
    exit: int
    cure: NotRequired[str]
    columns: NotRequired[list[dict[str, Any]]]


class Job(Kept):
    """A job of a workspace."""

    id: Id
    verb: str
    files: list[Id]
    target: str | None
    recipe: dict[str, Any]
    lang: str
    command: str
    state: Literal["waiting", "running", "done", "failed", "cancelled"]
    problem: Problem | None


class Workspace(Kept):
    """A workspace as it is kept."""

    id: str
    files: dict[Id, File]
    jobs: dict[Id, Job]
    choices: dict[str, Any]


class Channel(TypedDict):
    """A channel of a trace."""

    name: str
    unit: str
    rate: float
    size: Annotated[int, Field(gt=0)]
    offset: float
    raw: list[str]
    levels: Annotated[int, Field(ge=0, le=20)]
    gaps: list[tuple[float, float]]
    gap_count: int
    outliers: list[float]
    outlier_count: int


class Trace(TypedDict):
    """What a trace was made with, and of which channels."""

    key: str
    channels: Annotated[list[Channel], Field(min_length=1)]


def workspace(name: str) -> Any:
    """The schema of the workspace of this id."""

    def own(state: Any) -> Any:
        ids = [*state["files"].items(), *state["jobs"].items()]
        if state["id"] != name or any(key != row["id"] or not key.startswith(f"{name}-") for key, row in ids):
            raise ValueError(f"it has ids of another workspace than {name}")
        return state

    return Annotated[Workspace, AfterValidator(own)]


def plain(data: bytes, deepest: int = MAX_DEPTH) -> Any:
    """JSON that can be written and read again."""
    too_deep = f"lists and objects are nested more than {deepest} deep"
    try:
        value = from_json(data, allow_inf_nan=False)
    except ValueError as error:  # the parser, too, follows them to a depth only
        raise UsageError(too_deep if "recursion limit" in str(error) else f"this is not JSON: {error}") from None
    layer, deep = [value], 0
    while layer:
        if any(isinstance(v, (int, float)) and abs(v) > sys.float_info.max for v in layer):
            raise UsageError(f"a number is larger than {sys.float_info.max:.3g}")
        deep += 1
        if deep > deepest:
            raise UsageError(too_deep)
        parts = (v.values() if isinstance(v, dict) else v for v in layer if isinstance(v, (dict, list)))
        layer = [v for part in parts for v in part]
    return value


def fitting(schema: Any, data: bytes, deepest: int = MAX_DEPTH) -> Any:
    """JSON as its schema says."""
    try:
        return TypeAdapter(schema).validate_python(plain(data, deepest))
    except ValidationError as error:
        raise UsageError(faults(error)) from None


def faults(error: Any) -> str:
    """What does not fit, of the validation of a request or of a file."""
    return "; ".join(f"{'.'.join(map(str, fault['loc'])) or 'the request'}: {fault['msg']}" for fault in error.errors())


ASIDE = ".damaged"  # what the name of a file ends with that could not be read


def kept(path: Path, schema: Any, tell: Callable[[str], object] = complain) -> Any:
    """What a file of the page holds; None if there is none, or if it is damaged and has another name from now on."""
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise UsageError("not a file")
        return fitting(schema, path.read_bytes(), MAX_KEPT_DEPTH)
    except FileNotFoundError:
        return None
    except (OSError, UsageError) as error:
        aside = path.with_name(f"{path.name}{ASIDE}")
        try:
            path.replace(aside)
            how = f"It was renamed to {aside.name!r}"
        except OSError as other:
            how = f"It cannot be renamed to {aside.name!r} ({reason(other)})"
        tell(f"{str(path)!r} is damaged, or of another version of allanite ({reason(error)}). {how}; "
             "everything else works.")  # fmt: skip
        return None

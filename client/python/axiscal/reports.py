"""The reports of jobs as dataclasses (docs/formats.md; core/reports has the same fields in C++).

um and urad unless a name says otherwise. None stands for what the data cannot tell, or what a report does not say. Members that a newer
server adds are left out; one that has another type than said here is an InvalidArgument that names it.
"""
import dataclasses
import functools
import json
import types
import typing
from typing import Any, Dict, Mapping, Optional, Tuple, Type, TypeVar, Union

from axiscal.errors import InvalidArgument

_Report = TypeVar("_Report")


# ---- identification and loop


@dataclasses.dataclass(frozen=True)
class Error:
    symbol: str
    value: Optional[float] = None
    sigma: Optional[float] = None  # standard uncertainty
    unit: str = ""
    identifiable: bool = True
    name: str = ""  # EXX:backlash; empty where it is the symbol


@dataclasses.dataclass(frozen=True)
class Combination:
    name: str
    value: Optional[float] = None
    sigma: Optional[float] = None
    unit: str = ""


@dataclasses.dataclass(frozen=True)
class SetupOffset:
    value: Optional[float] = None
    sigma: Optional[float] = None
    unit: str = ""


@dataclasses.dataclass(frozen=True)
class SessionFit:
    session: str
    shared_setup: str = ""
    readings: int = 0
    rms_um: Optional[float] = None
    max_um: Optional[float] = None
    setup: Mapping[str, SetupOffset] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Outlier:
    session: str
    row: int = 0  # line of data, from 1
    column: int = 0
    residual_um: Optional[float] = None
    gate: Optional[str] = None
    off_um: Optional[float] = None
    limit_um: Optional[float] = None


@dataclasses.dataclass(frozen=True)
class Warning:
    kind: str
    text: str
    text_de: str = ""  # the same in German; empty in reports of earlier versions


@dataclasses.dataclass(frozen=True)
class Statistics:
    rms_um: Optional[float] = None
    max_um: Optional[float] = None
    rms_without_outliers_um: Optional[float] = None
    chi2_per_dof: Optional[float] = None
    readings: Optional[int] = None
    degrees_of_freedom: Optional[int] = None


@dataclasses.dataclass(frozen=True)
class SimulatedError:
    name: str
    value: Optional[float] = None
    mean: Optional[float] = None
    sigma: Optional[float] = None
    low: Optional[float] = None  # 95 %
    high: Optional[float] = None
    linear_sigma: Optional[float] = None
    unit: str = ""


Correlation = Tuple[Tuple[Optional[float], ...], ...]


@dataclasses.dataclass(frozen=True)
class MonteCarlo:
    runs: int = 0
    failed: int = 0
    seed: int = 0
    errors: Tuple[SimulatedError, ...] = ()
    correlation: Correlation = ()


@dataclasses.dataclass(frozen=True)
class HeldError:
    symbol: str
    value: Optional[float] = None
    sigma: Optional[float] = None
    unit: str = ""
    name: str = ""


@dataclasses.dataclass(frozen=True)
class MeasuredIn:
    session: str
    shared_setup: str = ""


@dataclasses.dataclass(frozen=True)
class AxisRange:
    axis: str
    from_: float = dataclasses.field(default=0.0, metadata={"member": "from"})
    to: float = 0.0
    unit: str = ""


@dataclasses.dataclass(frozen=True)
class Held:
    errors: Tuple[HeldError, ...] = ()
    correlation: Correlation = ()
    sessions: Tuple[MeasuredIn, ...] = ()


@dataclasses.dataclass(frozen=True)
class Identification:
    errors: Tuple[Error, ...] = ()
    not_separable: Tuple[str, ...] = ()
    measured: Tuple[AxisRange, ...] = ()  # where the readings stand; empty: not known
    determined: Tuple[Combination, ...] = ()
    coverage_factor: Optional[float] = None  # value +- this many sigma is the 95 % interval
    rank: int = 0
    parameters: int = 0
    condition: Optional[float] = None
    nominal: Statistics = Statistics()
    before: Optional[Statistics] = None
    fit: Statistics = Statistics()
    sessions: Tuple[SessionFit, ...] = ()
    outliers: Tuple[Outlier, ...] = ()
    warnings: Tuple[Warning, ...] = ()
    correlation: Correlation = ()
    held: Optional[Held] = None
    iterations: int = 0
    noise_scale: float = 1.0
    budget: Any = None  # as it was given
    monte_carlo: Optional[MonteCarlo] = None


@dataclasses.dataclass(frozen=True)
class Effect:
    name: str = ""
    symbol: str = ""
    shape: str = ""
    amplitude: Optional[float] = None
    amplitude_sigma: Optional[float] = None
    unit: str = ""
    phase_deg: Optional[float] = None
    alias_orders: Tuple[int, ...] = ()
    rms_um: Optional[float] = None
    evidence: Optional[float] = None
    equivalent: Tuple[Mapping[str, Any], ...] = ()  # what the sessions cannot tell from it
    same_always: Tuple[str, ...] = ()
    form: Mapping[str, Any] = dataclasses.field(default_factory=dict)  # the shape's own fields: variable, order ...


@dataclasses.dataclass(frozen=True)
class Cause:
    kind: str
    subject: str
    evidence: Optional[float] = None
    correction: str = ""
    subject_de: str = ""  # the same in German; empty in reports of earlier versions
    correction_de: str = ""


@dataclasses.dataclass(frozen=True)
class HeldBack:
    kind: str  # uncertain, undecided, no-gain
    subject: str
    evidence: Optional[float] = None
    harm: Optional[float] = None
    measure: str = ""


@dataclasses.dataclass(frozen=True)
class BeforeAfter:
    before: Statistics = Statistics()
    after: Statistics = Statistics()


@dataclasses.dataclass(frozen=True)
class Check:
    before: Statistics = Statistics()
    after: Statistics = Statistics()
    fitted: bool = False  # the check sessions were fitted too and prove nothing


@dataclasses.dataclass(frozen=True)
class VolumetricFigure:
    rms_um: Optional[float] = None
    low_um: Optional[float] = None
    high_um: Optional[float] = None


@dataclasses.dataclass(frozen=True)
class Volumetric:
    box: Tuple[AxisRange, ...] = ()
    poses: int = 0
    uncorrected: VolumetricFigure = VolumetricFigure()
    before: VolumetricFigure = VolumetricFigure()
    after: VolumetricFigure = VolumetricFigure()
    gain_is_held: bool = False
    weakest: Tuple[str, ...] = ()
    undecided: Tuple[str, ...] = ()
    unknown: Tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class SelectionStep:
    change: str
    name: str
    rms_um: Optional[float] = None


@dataclasses.dataclass(frozen=True)
class Slip:
    carrier: str = ""
    may_be: Optional[str] = None
    moved_um: Tuple[Optional[float], ...] = ()
    sigma_um: Tuple[Optional[float], ...] = ()


@dataclasses.dataclass(frozen=True)
class Unexplained:
    kind: str = ""
    variable: str = ""
    from_: Optional[float] = dataclasses.field(default=None, metadata={"member": "from"})
    to: Optional[float] = None
    unit: str = ""
    session: str = ""
    rms_um: Optional[float] = None
    slip: Optional[Slip] = None


@dataclasses.dataclass(frozen=True)
class Proposal:
    effect: str
    separates: Tuple[str, ...] = ()
    session: Optional[str] = None  # None: no known test helps
    test: str = ""
    text: str = ""
    correlation_before: Optional[float] = None
    correlation_after: Optional[float] = None
    expected_chi2: Optional[float] = None
    needs_next: bool = False
    beyond: str = ""
    remaining: Tuple[str, ...] = ()
    same_always: Tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class SessionNoise:
    session: str
    stated_sigma_um: Optional[float] = None
    sigma_um: Optional[float] = None
    neighbour_correlation: Optional[float] = None


@dataclasses.dataclass(frozen=True)
class Loop:
    verdict: str  # adequate, extended, unexplained
    effects: Tuple[Effect, ...] = ()
    causes: Tuple[Cause, ...] = ()
    held_back: Tuple[HeldBack, ...] = ()  # found, but the machine could be worse for it: not corrected
    errors: Tuple[Error, ...] = ()
    coverage_factor: Optional[float] = None
    not_separable: Tuple[str, ...] = ()
    measured: Tuple[AxisRange, ...] = ()  # where the readings stand; empty: not known
    determined: Tuple[Combination, ...] = ()
    warnings: Tuple[Warning, ...] = ()
    fit: BeforeAfter = BeforeAfter()
    check: Optional[Check] = None
    volumetric: Optional[Volumetric] = None
    steps: Tuple[SelectionStep, ...] = ()
    unexplained: Tuple[Unexplained, ...] = ()
    outliers: Tuple[Outlier, ...] = ()
    next_measurement: Tuple[Proposal, ...] = ()
    noise: Tuple[SessionNoise, ...] = ()
    withdrawn: Tuple[str, ...] = ()
    not_visible: Tuple[Mapping[str, Any], ...] = ()
    axes_at_rest: Tuple[str, ...] = ()
    stopped_early: bool = False
    sessions: Tuple[SessionFit, ...] = ()
    candidates: int = 0
    budget: Any = None
    monte_carlo: Optional[MonteCarlo] = None


# ---- compensation


@dataclasses.dataclass(frozen=True)
class Spread:
    max_um: float = 0.0
    rms_um: float = 0.0
    count: int = 0


@dataclasses.dataclass(frozen=True)
class AngleSpread:
    max_urad: float = 0.0
    rms_urad: float = 0.0
    count: int = 0


@dataclasses.dataclass(frozen=True)
class SpreadBeforeAfter:
    before: Spread = Spread()
    after: Spread = Spread()


@dataclasses.dataclass(frozen=True)
class AngleSpreadBeforeAfter:
    before: AngleSpread = AngleSpread()
    after: AngleSpread = AngleSpread()


@dataclasses.dataclass(frozen=True)
class AlongPath:
    before_at_most_um: float = 0.0
    after_at_most_um: float = 0.0


@dataclasses.dataclass(frozen=True)
class Finding:
    line: int  # of the source, from 1
    block: str = ""
    reason: str = ""


@dataclasses.dataclass(frozen=True)
class LineRange:
    first: int
    last: int
    reason: str = ""


@dataclasses.dataclass(frozen=True)
class Blocks:
    read: int = 0
    corrected: int = 0
    split: int = 0
    inserted: int = 0
    passed: int = 0
    refused: int = 0
    going_back: int = 0  # of inserted: Rewrite.ways_back


@dataclasses.dataclass(frozen=True)
class Orientation:
    max_rotary_correction_deg: float = 0.0
    correction: Mapping[str, AngleSpread] = dataclasses.field(default_factory=dict)
    error: AngleSpreadBeforeAfter = AngleSpreadBeforeAfter()
    blocks_not_reached: int = 0
    not_reached: Tuple[Finding, ...] = ()


@dataclasses.dataclass(frozen=True)
class Holes:
    corrected: int = 0
    left_max_um: float = 0.0
    not_exact: int = 0
    left: Tuple[Finding, ...] = ()


@dataclasses.dataclass(frozen=True)
class Shift:
    """Of the moves of one tool in one work offset, all linear axes together."""
    tool: str = ""
    work_offset: str = ""
    moves: int = 0
    max_um: float = 0.0
    rms_um: float = 0.0
    line: int = 0  # of the largest
    at: Mapping[str, float] = dataclasses.field(default_factory=dict)  # axis positions, mm and deg


@dataclasses.dataclass(frozen=True)
class Extremes:
    """Corrections of one axis, corrected less programmed."""
    low_um: float = 0.0
    high_um: float = 0.0


@dataclasses.dataclass(frozen=True)
class Stretch:
    """Moves that follow each other, with the extremes of what was done to them."""
    first: int  # line of the source, from 1, of its first move
    last: int
    way_mm: float = 0.0  # from the first corrected position to the end of this stretch
    correction: Mapping[str, Extremes] = dataclasses.field(default_factory=dict)  # of each linear axis
    before_max_um: float = 0.0  # predicted error of the tool point there
    after_max_um: float = 0.0


@dataclasses.dataclass(frozen=True)
class WayBack:
    """A move that was added in front of a block which is left as it is."""
    line: int  # of the source, from 1: of that block
    block: str = ""  # as it was added
    way_um: float = 0.0  # of all linear axes together


@dataclasses.dataclass(frozen=True)
class Rewrite:
    calibration: str = ""
    calibration_warnings: Tuple[Warning, ...] = ()  # of its own report
    calibration_causes: Tuple[Cause, ...] = ()  # the correction may be wrong by them
    dialect: str = ""
    null_correction: bool = False  # the output is the input
    blocks: Blocks = Blocks()
    correction: Mapping[str, Spread] = dataclasses.field(default_factory=dict)  # of each linear axis
    shifts: Tuple[Shift, ...] = ()
    rotary_stood_deg: Mapping[str, float] = dataclasses.field(default_factory=dict)
    missing: Tuple[str, ...] = ()  # options, in the words to add
    tool_point_error: SpreadBeforeAfter = SpreadBeforeAfter()
    tool_point_error_along_path: AlongPath = AlongPath()
    path: Tuple[Stretch, ...] = ()  # all that was corrected, in order
    max_tilt_left_urad: float = 0.0
    orientation: Optional[Orientation] = None
    holes: Optional[Holes] = None
    contours: Optional[Holes] = None
    max_departure_um: float = 0.0
    positions: Tuple[AxisRange, ...] = ()  # of each axis, at the ends of what was corrected
    passed: Tuple[Finding, ...] = ()
    refused: Tuple[Finding, ...] = ()
    ways_back: Tuple[WayBack, ...] = ()  # the first 100; blocks.going_back is their number
    ranges_not_corrected: int = 0
    not_corrected: Tuple[LineRange, ...] = ()
    notes: Tuple[str, ...] = ()
    source_crc32c: Optional[str] = None


# ---- tool setter


@dataclasses.dataclass(frozen=True)
class ToolSetter:
    """Of rods or of a round-insert mill: `values` is the report as it stands in docs/formats.md ("Tool-setter reports")."""
    values: Mapping[str, Any] = dataclasses.field(default_factory=dict)


# ---- the reader


def read(cls: Type[_Report], text: str) -> _Report:
    """A report of JSON. InvalidArgument names the member that is wrong."""
    document = _parse(text)
    if cls is ToolSetter:
        return cls(document)  # type: ignore[call-arg]
    return typing.cast(_Report, _object(cls, document, "report"))


def read_calibration(text: str) -> Union[Identification, Loop]:
    """The report of a calibration: a loop's report has a verdict."""
    return read(Loop, text) if "verdict" in _parse(text) else read(Identification, text)


def _parse(text: str) -> Dict[str, Any]:
    try:
        document = json.loads(text)
    except ValueError as error:
        raise InvalidArgument(f"report: {error}") from None
    if not isinstance(document, dict):
        raise InvalidArgument(f"report: {type(document).__name__}, expected an object")
    return document


@functools.lru_cache(maxsize=None)
def _types_of(cls: type) -> Dict[str, Any]:
    return typing.get_type_hints(cls)


def _object(cls: type, document: Any, place: str) -> Any:
    if not isinstance(document, dict):
        raise InvalidArgument(f"{place}: {json.dumps(document)[:40]}, expected an object")
    values = {}
    left = dict(document)
    for field in dataclasses.fields(cls):
        member = field.metadata.get("member", field.name)
        if member in left:
            values[field.name] = _value(_types_of(cls)[field.name], left.pop(member), f"{place}.{member}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InvalidArgument(f"{place}.{member}: is missing")
    if cls is Effect:
        values["form"] = left
    return cls(**values)


def _value(kind: Any, value: Any, place: str) -> Any:
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return value
    if origin is Union:
        return None if value is None else _value(arguments[0], value, place)
    if origin is tuple:
        if isinstance(value, list):
            return tuple(_value(arguments[0], item, f"{place}[{index}]") for index, item in enumerate(value))
        raise InvalidArgument(f"{place}: {json.dumps(value)[:40]}, expected a list")
    if dataclasses.is_dataclass(kind):
        return _object(typing.cast(type, kind), value, place)
    if origin is not None:  # Mapping
        if isinstance(value, dict):
            return types.MappingProxyType({key: _value(arguments[1], item, f"{place}.{key}") for key, item in value.items()})
        raise InvalidArgument(f"{place}: {json.dumps(value)[:40]}, expected an object")
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, kind) and not (kind is int and isinstance(value, bool)):
        return value
    raise InvalidArgument(f"{place}: {json.dumps(value)[:40]}, expected {kind.__name__}")

"""Errors over time as tables."""
import dataclasses
import datetime
from typing import Any, Dict, Iterable, List, Optional, Tuple

import numpy as np
import pandas as pd

from axiscal.records import UNITS, CalibrationState, utc
from axiscal.v1 import calibration_pb2, history_service_pb2

_NAN = float("nan")


def _times(microseconds: List[int]) -> pd.Series:
    return pd.Series(pd.to_datetime(np.asarray(microseconds, np.int64), unit="us", utc=True))


def points_frame(response: history_service_pb2.QueryDriftResponse) -> pd.DataFrame:
    """The columns of Client.drift(). Whole columns are made and converted once, as a table row by row takes seconds."""
    names = [series.symbol for series in response.series]
    counts = [len(series.points) for series in response.series]
    points = [point for series in response.series for point in series.points]
    units = [UNITS.get(series.unit, "") for series in response.series]

    return pd.DataFrame({
        "symbol": pd.Series(np.repeat(np.array(names, object), counts), dtype=object),
        "unit": pd.Series(np.repeat(np.array(units, object), counts), dtype=object),
        "first": _times([point.first_utc_us for point in points]),
        "last": _times([point.last_utc_us for point in points]),
        "count": np.array([point.count for point in points], np.int64),
        "min": np.array([point.min_value for point in points], np.float64),
        "max": np.array([point.max_value for point in points], np.float64),
        "mean": np.array([point.mean_value for point in points], np.float64),
        # HasField is slow; a sigma that is not set reads as 0.
        "sigma": np.array([point.sigma or (0.0 if point.HasField("sigma") else _NAN) for point in points], np.float64),
        "calibration": np.array([point.last_calibration_id for point in points], np.int64),
    })


def residuals_frame(pages: List[Any]) -> pd.DataFrame:
    """The columns of Client.residuals(), of all its pages."""
    axes = list(pages[0].axes)
    residuals = [residual for page in pages for residual in page.residuals]
    counts = [len(residual.after_um) for residual in residuals]

    def column(values: List[Any], kind: Any) -> Any:
        return np.repeat(np.array(values, kind), counts)

    frame = {
        "session": column([residual.session_id for residual in residuals], np.int64),
        "reading": column([residual.reading for residual in residuals], np.int64),
        "row": np.array([row for count in counts for row in range(count)], np.int64),
    }
    for number, name in enumerate(axes):
        frame[name] = column([residual.positions_mm_or_deg[number] if residual.positions_mm_or_deg else _NAN for residual in residuals], np.float64)
    for name in ("time_s", "temperature_celsius"):
        frame[name] = column([getattr(residual, name) if residual.HasField(name) else _NAN for residual in residuals], np.float64)
    for name in ("before_um", "after_um"):
        frame[name] = np.array([value for residual in residuals for value in getattr(residual, name)], np.float64)
    frame["is_set_aside"] = column([residual.is_set_aside for residual in residuals], bool)
    return pd.DataFrame(frame)


def volumetric_frame(errors: List[Any]) -> pd.DataFrame:
    """The columns of Client.volumetric(), the oldest first."""
    errors = sorted(errors, key=lambda error: (error.measured_utc_us, error.calibration_id))
    frame: Dict[str, Any] = {
        "calibration": np.array([error.calibration_id for error in errors], np.int64),
        "measured": _times([error.measured_utc_us for error in errors]),
        "state": pd.Series([CalibrationState[calibration_pb2.CalibrationState.Name(error.state)[len("CALIBRATION_STATE_"):]].name
                            for error in errors], dtype=object),
        "known_share": np.array([_NAN if error.problem else error.known_share for error in errors], np.float64),
        "poses": np.array([error.poses for error in errors], np.int64),
    }
    for when in ("uncorrected", "before", "after"):
        for what in ("rms", "median", "p95", "max"):
            for end, field in (("", "expected_um"), ("_low", "low_um"), ("_high", "high_um")):
                frame[f"{when}_{what}{end}"] = np.array(
                    [getattr(getattr(getattr(error, when), what), field) if error.HasField(when) else _NAN for error in errors], np.float64)
    frame["problem"] = pd.Series([error.problem for error in errors], dtype=object)
    return pd.DataFrame(frame)


@dataclasses.dataclass(frozen=True)
class Amount:
    symbol: str
    size: float  # now - before, per year, or amplitude, in `unit`
    sigma: float
    unit: str


@dataclasses.dataclass(frozen=True)
class DriftFinding:
    kind: str  # step, retraction, suspect, slope, season, noise, unstable (docs/drift.md)
    text: str
    at: datetime.datetime
    after: Optional[datetime.datetime]
    by: Optional[datetime.datetime]
    amounts: Tuple[Amount, ...]
    certainty: Optional[float]
    is_revision: bool
    is_over: bool


@dataclasses.dataclass(frozen=True)
class Forecast:
    symbol: str
    low: float
    high: float
    unit: str
    text: str
    probability_now: Optional[float]
    probability_within_year: Optional[float]
    earliest: Optional[datetime.datetime]  # outside by then with 5 %
    median: Optional[datetime.datetime]  # with 50 %
    latest: Optional[datetime.datetime]  # with 95 %


@dataclasses.dataclass(frozen=True)
class DriftReport:
    """What happened to a machine, in words and numbers."""
    findings: Tuple[DriftFinding, ...]
    forecasts: Tuple[Forecast, ...]
    calibration_ids: Tuple[int, ...]  # that count, the oldest first
    calibrations: int  # that the machine has in all
    not_counted: Dict[int, str]  # calibration -> why it cannot be followed

    def to_frame(self) -> pd.DataFrame:
        """A row for each error of each finding: finding (its place in `findings`), kind, at, after, by, symbol, size, sigma, unit,
        certainty, is_revision, is_over, text. Findings without an error have one row, with an empty symbol."""
        rows: List[Tuple[int, DriftFinding, Amount]] = []
        for number, finding in enumerate(self.findings):
            rows += [(number, finding, amount) for amount in finding.amounts or (Amount("", _NAN, _NAN, ""),)]

        def times(values: Iterable[Optional[datetime.datetime]]) -> pd.Series:
            return pd.Series(pd.to_datetime(pd.Series(list(values), dtype=object), utc=True), dtype="datetime64[ns, UTC]")

        def floats(values: Iterable[Optional[float]]) -> Any:
            return np.array([_NAN if value is None else value for value in values], np.float64)

        return pd.DataFrame({
            "finding": np.array([number for number, _, _ in rows], np.int64),
            "kind": pd.Series([finding.kind for _, finding, _ in rows], dtype=object),
            "at": times(finding.at for _, finding, _ in rows),
            "after": times(finding.after for _, finding, _ in rows),
            "by": times(finding.by for _, finding, _ in rows),
            "symbol": pd.Series([amount.symbol for _, _, amount in rows], dtype=object),
            "size": floats(amount.size for _, _, amount in rows),
            "sigma": floats(amount.sigma for _, _, amount in rows),
            "unit": pd.Series([amount.unit for _, _, amount in rows], dtype=object),
            "certainty": floats(finding.certainty for _, finding, _ in rows),
            "is_revision": np.array([finding.is_revision for _, finding, _ in rows], bool),
            "is_over": np.array([finding.is_over for _, finding, _ in rows], bool),
            "text": pd.Series([finding.text for _, finding, _ in rows], dtype=object),
        })

    @classmethod
    def from_message(cls, response: Any) -> "DriftReport":
        def optional(message: Any, field: str) -> Any:
            return getattr(message, field) if message.HasField(field) else None

        def time(message: Any, field: str) -> Optional[datetime.datetime]:
            return utc(getattr(message, field)) if message.HasField(field) else None

        kinds = history_service_pb2.DriftFindingKind
        findings = tuple(
            DriftFinding(
                kinds.Name(finding.kind)[len("DRIFT_FINDING_KIND_"):].lower() if finding.kind in kinds.values() else "unknown", finding.text,
                utc(finding.at_utc_us), time(finding, "after_utc_us"), time(finding, "by_utc_us"),
                tuple(Amount(amount.symbol, amount.size, amount.sigma, UNITS.get(amount.unit, "")) for amount in finding.amounts),
                optional(finding, "certainty"), finding.is_revision, finding.is_over) for finding in response.findings)
        forecasts = tuple(
            Forecast(forecast.limit.symbol, forecast.limit.low, forecast.limit.high, UNITS.get(forecast.unit, ""), forecast.text,
                     optional(forecast, "probability_now"), optional(forecast, "probability_within_year"), time(forecast, "earliest_utc_us"),
                     time(forecast, "median_utc_us"), time(forecast, "latest_utc_us")) for forecast in response.limits)
        return cls(findings, forecasts, tuple(response.calibration_ids), response.calibrations,
                   {entry.calibration_id: entry.text for entry in response.not_counted})

-- What people say of sessions: notes, labels, and which do not count; until when jobs must have ended.

CREATE TABLE session_remark (
  session_id INTEGER PRIMARY KEY REFERENCES session (id),
  note TEXT NOT NULL,
  is_rejected INTEGER NOT NULL CHECK (is_rejected IN (0, 1)),
  reason TEXT NOT NULL,
  etag INTEGER NOT NULL CHECK (etag >= 1),
  changed_by TEXT NOT NULL,
  changed_at_utc_us INTEGER NOT NULL
) STRICT;

CREATE TABLE session_label (
  session_id INTEGER NOT NULL REFERENCES session (id),
  label TEXT NOT NULL,
  PRIMARY KEY (session_id, label)
) STRICT, WITHOUT ROWID;

ALTER TABLE job ADD COLUMN deadline_at_utc_us INTEGER;
CREATE INDEX job_waiting_until ON job (deadline_at_utc_us) WHERE state = 1 AND deadline_at_utc_us IS NOT NULL;

-- The calibrations of a machine that were ever in use, by when.
CREATE INDEX calibration_ever_approved ON calibration (machine_id, approved_at_utc_us) WHERE approved_at_utc_us IS NOT NULL;
CREATE INDEX run_approved ON routine_run (calibration_id) WHERE state = 5;

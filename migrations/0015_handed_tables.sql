-- Compensation tables that were handed out: a control may have them, so that programs must not be corrected by the same calibration.

CREATE TABLE handed_table (
  calibration_id INTEGER NOT NULL REFERENCES calibration (id),
  format TEXT NOT NULL,
  handed_to TEXT NOT NULL,
  handed_at_utc_us INTEGER NOT NULL CHECK (handed_at_utc_us >= 0),
  PRIMARY KEY (calibration_id, format)
) STRICT, WITHOUT ROWID;

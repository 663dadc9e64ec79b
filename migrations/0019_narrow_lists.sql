-- What lists may be held to beside machine and state has its index, in the order of numbers, and so have the times.

CREATE INDEX session_with_name ON session (name);
CREATE INDEX session_of_machine_with_name ON session (machine_id, name);
CREATE INDEX session_with_instrument ON session (instrument);
CREATE INDEX session_of_machine_with_instrument ON session (machine_id, instrument);
CREATE INDEX session_at ON session (coalesce(measured_at_utc_us, created_at_utc_us));
CREATE INDEX session_of_machine_at ON session (machine_id, coalesce(measured_at_utc_us, created_at_utc_us));
CREATE INDEX session_with_label ON session_label (label, session_id);

CREATE INDEX job_with_kind ON job (kind);
CREATE INDEX job_of_machine_with_kind ON job (machine_id, kind);
CREATE INDEX job_at ON job (created_at_utc_us);
CREATE INDEX job_of_machine_at ON job (machine_id, created_at_utc_us);

CREATE INDEX calibration_at ON calibration (measured_at_utc_us);
CREATE INDEX calibration_of_machine_at ON calibration (machine_id, measured_at_utc_us);

-- Each filter of a list has its index, in the list's order: a page costs the same however many rows do not fit the filter.

CREATE INDEX session_by_state ON session (state);
CREATE INDEX session_by_machine_state ON session (machine_id, state);

CREATE INDEX job_by_state ON job (state);
CREATE INDEX job_by_machine_state ON job (machine_id, state);

CREATE INDEX calibration_of_machine ON calibration (machine_id);
CREATE INDEX calibration_by_state ON calibration (state);
CREATE INDEX calibration_by_machine_state ON calibration (machine_id, state);
-- Since when the fleet's newest estimates may be from.
CREATE INDEX calibration_in_use ON calibration (machine_id, measured_at_utc_us) WHERE state <> 3;

CREATE INDEX program_by_state ON program (state);
CREATE INDEX program_by_kind_state ON program (kind, state);

-- The times of lists by blocks of 1,024 numbers: a list by falling number finds what is of a time by one look at each
-- block, however many rows are of no such time, and of which numbers those are that are.

DROP INDEX session_at;
DROP INDEX session_of_machine_at;
DROP INDEX job_at;
DROP INDEX job_of_machine_at;
DROP INDEX calibration_at;
DROP INDEX calibration_of_machine_at;

CREATE INDEX session_at ON session (id >> 10, coalesce(measured_at_utc_us, created_at_utc_us));
CREATE INDEX session_of_machine_at ON session (machine_id, id >> 10, coalesce(measured_at_utc_us, created_at_utc_us));
CREATE INDEX job_at ON job (id >> 10, created_at_utc_us);
CREATE INDEX job_of_machine_at ON job (machine_id, id >> 10, created_at_utc_us);
CREATE INDEX calibration_at ON calibration (id >> 10, measured_at_utc_us);
CREATE INDEX calibration_of_machine_at ON calibration (machine_id, id >> 10, measured_at_utc_us);

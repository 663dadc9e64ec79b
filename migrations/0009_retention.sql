-- Removal by age, and a fair queue.
-- Readings of complete sessions may go by age, those of what calibrations stand on never. Such a session becomes EXPIRED.

CREATE INDEX calibration_of_session ON calibration_session (session_id);
CREATE TRIGGER calibrations_keep_their_sessions BEFORE UPDATE OF state ON session
WHEN OLD.state = 2 AND EXISTS (SELECT 1 FROM calibration_session WHERE session_id = OLD.id)
BEGIN SELECT RAISE (ABORT, 'a calibration stands on this session'); END;

-- Whose chunks are being removed, some at a time.
CREATE INDEX session_emptied ON session (id) WHERE state = 4 AND next_seq > 0;

-- Whose jobs wait or run, and whose turn it is: a queue that one principal has filled lets others through.
CREATE INDEX job_by_creator_state ON job (created_by, state);
CREATE INDEX job_waiting_of ON job (created_by, priority DESC, id) WHERE state = 1;
CREATE TABLE job_turn (
  created_by TEXT PRIMARY KEY,
  turn INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX job_last_turn ON job_turn (turn);

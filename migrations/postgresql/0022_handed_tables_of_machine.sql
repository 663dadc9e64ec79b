-- Tables that were handed out by machine: a control corrects by one whichever calibration of the machine it is of.
CREATE TABLE handed_table_of_machine (
  machine_id BIGINT NOT NULL REFERENCES machine (id),
  calibration_id BIGINT NOT NULL REFERENCES calibration (id),
  format TEXT COLLATE "C" NOT NULL,
  handed_to TEXT COLLATE "C" NOT NULL,
  handed_at_utc_us BIGINT NOT NULL CHECK (handed_at_utc_us >= 0),
  PRIMARY KEY (machine_id, calibration_id, format)
);

INSERT INTO handed_table_of_machine (machine_id, calibration_id, format, handed_to, handed_at_utc_us)
SELECT c.machine_id, h.calibration_id, h.format, h.handed_to, h.handed_at_utc_us
FROM handed_table AS h JOIN calibration AS c ON c.id = h.calibration_id;

DROP TABLE handed_table;
ALTER TABLE handed_table_of_machine RENAME TO handed_table;

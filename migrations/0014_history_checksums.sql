-- Checksums of the rows that histories are drawn from: row_crc32c() is server/storage/row_checksum.h.

ALTER TABLE estimate ADD COLUMN crc32c INTEGER;
UPDATE estimate AS e SET crc32c =
  (SELECT row_crc32c(e.machine_id, e.symbol, e.measured_at_utc_us, e.calibration_id, e.position, e.unit, e.identifiable,
     e.estimated_um_urad, e.sigma_um_urad, c.state = 3 AND c.approved_at_utc_us IS NULL)
   FROM calibration AS c WHERE c.id = e.calibration_id);

ALTER TABLE estimate_week ADD COLUMN crc32c INTEGER;
UPDATE estimate_week SET crc32c = row_crc32c(machine_id, symbol, week, unit, estimate_count, not_identifiable_count,
  min_um_urad, max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us, last_sigma_um_urad, last_calibration_id);

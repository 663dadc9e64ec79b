-- A candidate that was retired without ever having been approved is no point of a machine's history: the weeks that hold one
-- are summed again without it.

UPDATE estimate_week AS w SET
  (estimate_count, not_identifiable_count, min_um_urad, max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us) =
    (SELECT count(e.estimated_um_urad), count(*) - count(e.estimated_um_urad), min(e.estimated_um_urad),
       max(e.estimated_um_urad), sum(e.estimated_um_urad),
       min(iif(e.estimated_um_urad IS NULL, NULL, e.measured_at_utc_us)),
       max(iif(e.estimated_um_urad IS NULL, NULL, e.measured_at_utc_us))
     FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
     WHERE e.machine_id = w.machine_id AND e.symbol = w.symbol
       AND e.measured_at_utc_us >= w.week * 604800000000 AND e.measured_at_utc_us < (w.week + 1) * 604800000000
       AND NOT (c.state = 3 AND c.approved_at_utc_us IS NULL)),
  (last_sigma_um_urad, last_calibration_id) =
    (SELECT e.sigma_um_urad, e.calibration_id
     FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
     WHERE e.machine_id = w.machine_id AND e.symbol = w.symbol AND e.estimated_um_urad IS NOT NULL
       AND e.measured_at_utc_us >= w.week * 604800000000 AND e.measured_at_utc_us < (w.week + 1) * 604800000000
       AND NOT (c.state = 3 AND c.approved_at_utc_us IS NULL)
     ORDER BY e.measured_at_utc_us DESC, e.calibration_id DESC LIMIT 1)
WHERE EXISTS (SELECT 1 FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
  WHERE e.machine_id = w.machine_id AND e.symbol = w.symbol
    AND e.measured_at_utc_us >= w.week * 604800000000 AND e.measured_at_utc_us < (w.week + 1) * 604800000000
    AND c.state = 3 AND c.approved_at_utc_us IS NULL);

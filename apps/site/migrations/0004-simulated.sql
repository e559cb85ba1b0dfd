-- SPDX-License-Identifier: Apache-2.0
-- What is simulated stays apart from what is real. Before, a run on a virtual rig, whose clock may be a year ahead,
-- took the place of the rig's own: a thermometer lost its certificate, a unit drifted from what a dry run had said of
-- it, and a model's statistics had units that never were. And on a rig there was, for ever, a run that had no end.

-- As before, but that a run on a virtual rig says nothing of the rig's thermometers.
CREATE OR REPLACE FUNCTION gyrotherm.add_run(a_run uuid, a_rig text, a_info jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  begun timestamptz := gyrotherm.utc((a_info->>'started_ns')::bigint);
  kept jsonb := a_info - 'channels';
  there gyrotherm.run;
  is_new boolean := false;
BEGIN
  IF begun IS NULL OR begun < 'epoch' OR begun >= '2117-01-01' THEN
    PERFORM gyrotherm.refuse('no run starts then');
  END IF;
  IF NOT EXISTS (SELECT FROM gyrotherm.run WHERE id = a_run) THEN
    PERFORM gyrotherm.own_rig(a_rig);
    PERFORM gyrotherm.make_month(begun);
    INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info)
    VALUES (a_run, a_rig, session_user, begun, a_info->>'profile', (a_info->>'simulated')::boolean,
            (a_info->>'imported')::boolean, kept)
    ON CONFLICT DO NOTHING;
    is_new := FOUND;
  END IF;
  IF NOT is_new THEN -- or somebody was faster
    there := gyrotherm.own_run(a_run);
    IF there.info <> kept OR there.rig <> a_rig THEN
      PERFORM gyrotherm.refuse('the run that is there is another one');
    END IF;
    RETURN;
  END IF;
  INSERT INTO gyrotherm.channel(run, position, name, unit, measures, unit_under_test, words, calibration)
  SELECT a_run, c.position, c.value->>'name', c.value->>'unit', c.value->>'measures', c.value->>'unit_under_test',
         CASE WHEN c.value ? 'words' THEN ARRAY(SELECT jsonb_array_elements_text(c.value->'words')) END,
         c.value->'calibration'
  FROM jsonb_array_elements(a_info->'channels') WITH ORDINALITY AS c(value, position);
  INSERT INTO gyrotherm.unit(serial_number, model)
  SELECT DISTINCT u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '' ON CONFLICT DO NOTHING;
  INSERT INTO gyrotherm.run_unit(run, label, serial_number, model)
  SELECT a_run, u->>'label', u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '';
  IF (a_info->>'simulated')::boolean THEN RETURN; END IF;
  INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
  SELECT a_rig, c->>'name', c->'calibration'->>'instrument', c->'calibration'->>'certificate',
         nullif(c->'calibration'->>'calibrated', '')::date, nullif(c->'calibration'->>'due', '')::date, a_run, begun
  FROM jsonb_array_elements(a_info->'channels') c WHERE c->>'measures' = 'temperature' AND c ? 'calibration'
  ON CONFLICT (rig, name) DO UPDATE SET instrument = EXCLUDED.instrument, certificate = EXCLUDED.certificate,
    calibrated = EXCLUDED.calibrated, due = EXCLUDED.due, run = EXCLUDED.run, started = EXCLUDED.started
  WHERE gyrotherm.thermometer.started < EXCLUDED.started;
END
$$;

-- What was written over still stands with the runs. A rig that adds one meanwhile waits.
LOCK TABLE gyrotherm.thermometer IN SHARE ROW EXCLUSIVE MODE;
DELETE FROM gyrotherm.thermometer;
INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
SELECT DISTINCT ON (r.rig, c.name) r.rig, c.name, c.calibration->>'instrument', c.calibration->>'certificate',
       nullif(c.calibration->>'calibrated', '')::date, nullif(c.calibration->>'due', '')::date, r.id, r.started
FROM gyrotherm.run r JOIN gyrotherm.channel c ON c.run = r.id
WHERE NOT r.simulated AND c.measures = 'temperature' AND c.calibration IS NOT NULL
ORDER BY r.rig, c.name, r.started DESC, r.id;

-- A report replaces only one of its own kind. One that comes meanwhile waits here, before it counts anew.
LOCK TABLE gyrotherm.calibration_result IN SHARE ROW EXCLUSIVE MODE;
CREATE OR REPLACE VIEW gyrotherm.current_calibration AS
  SELECT c.* FROM gyrotherm.calibration c JOIN gyrotherm.document d USING (sha256)
  WHERE c.state <> 'superseded' AND NOT EXISTS (
    SELECT FROM gyrotherm.calibration o JOIN gyrotherm.document p USING (sha256)
    WHERE o.serial_number = c.serial_number AND o.model = c.model AND o.simulated = c.simulated
      AND (p.owner = d.owner OR c.state = 'draft')
      AND (o.state = 'superseded' AND o.number = c.number AND c.number <> ''
           OR o.state <> 'superseded' AND o.calibrated = c.calibrated AND (o.number = c.number OR c.state = 'draft')
              AND (o.state, o.sha256) < (c.state, c.sha256)));

-- As before, of real calibrations and of simulated ones by themselves.
CREATE OR REPLACE FUNCTION gyrotherm.make_drift(a_serial_number text, a_model text) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM pg_advisory_xact_lock(hashtext('gyrotherm.make_drift'), hashtext(a_serial_number || ' ' || a_model));
  DELETE FROM gyrotherm.drift WHERE serial_number = a_serial_number AND model = a_model;
  INSERT INTO gyrotherm.drift
  SELECT sha256, result, serial_number, model, axis, stage, quantity, condition, unit, calibrated, value,
         expanded_uncertainty, calibrated_before, value_before, change,
         change / nullif(sqrt(expanded_uncertainty ^ 2 + uncertainty_before ^ 2), 0), calibrated = newest,
         hashtextextended(concat_ws('|', model, axis, stage, quantity, condition, unit,
                                    CASE WHEN simulated THEN 'simulated' END), 0)
  FROM (
    SELECT *, CASE WHEN stage <> 'as_left' OR stage_before <> 'as_found' THEN value - value_before END AS change
    FROM (
      SELECT c.*, r.number AS result, r.axis, r.stage, r.quantity, r.condition, r.unit, r.value, r.expanded_uncertainty,
             lag(r.value) OVER series AS value_before, lag(r.expanded_uncertainty) OVER series AS uncertainty_before,
             lag(r.stage) OVER series AS stage_before, lag(c.calibrated) OVER series AS calibrated_before,
             max(c.calibrated) OVER (PARTITION BY c.simulated) AS newest
      FROM gyrotherm.current_calibration c JOIN gyrotherm.calibration_result r USING (sha256)
      WHERE c.serial_number = a_serial_number AND c.model = a_model AND r.expanded_uncertainty IS NOT NULL
        AND NOT r.in_sample
      WINDOW series AS (PARTITION BY c.simulated, r.axis, r.stage = 'uncompensated', r.quantity, r.condition, r.unit
                        ORDER BY c.calibrated, r.stage, c.sha256)
    ) pairs
  ) changes;
END
$$;

-- Only where there are both kinds does anything change.
SELECT gyrotherm.make_drift(serial_number, model)
FROM (SELECT DISTINCT serial_number, model FROM gyrotherm.calibration WHERE simulated
      ORDER BY serial_number, model) simulated_once;

CREATE OR REPLACE VIEW gyrotherm.v1_outlier AS
  WITH middle AS (
    SELECT lot, array_agg(value) AS numbers, percentile_cont(0.5) WITHIN GROUP (ORDER BY value) AS median
    FROM gyrotherm.drift WHERE is_newest AND value IS NOT NULL GROUP BY lot HAVING count(*) >= 5
  ), spread AS MATERIALIZED (
    SELECT lot, cardinality(numbers) AS units, median,
           (SELECT percentile_cont(0.5) WITHIN GROUP (ORDER BY abs(n - median)) FROM unnest(numbers) n) AS mad
    FROM middle
  )
  SELECT d.serial_number, d.model, d.axis, d.stage, d.quantity, d.condition, d.calibrated, d.value, d.unit, s.median,
         s.mad, 0.6745 * (d.value - s.median) / s.mad AS robust_z, s.units, c.simulated
  FROM spread s JOIN gyrotherm.drift d USING (lot) JOIN gyrotherm.calibration c USING (sha256)
  WHERE d.is_newest AND d.value IS NOT NULL AND s.mad > 0 AND abs(0.6745 * (d.value - s.median) / s.mad) > 3.5;

-- Runs that somebody should look at, and why. An alarm is what an interlock did, a warning too, whose event is of the
-- kind `fault`; it stands until an event acknowledges its number (docs/interlocks.md). A run is silent where it is
-- neither finished nor aborted and its last row is ten minutes old.
CREATE OR REPLACE VIEW gyrotherm.v1_attention AS
  SELECT r.id AS run, r.rig, r.started, r.profile, a.what, a.detail, r.simulated
  FROM gyrotherm.run r
  CROSS JOIN LATERAL (
    SELECT 'aborted' AS what, r.cause AS detail WHERE r.state IN ('aborting', 'aborted')
    UNION ALL
    SELECT 'alarm', e.text FROM gyrotherm.event e
    WHERE e.run = r.id AND e.kind IN ('interlock', 'fault') AND e.interlock <> '' AND NOT EXISTS (
      SELECT FROM gyrotherm.event k WHERE k.run = r.id AND k.kind = 'acknowledged'
        AND k.text LIKE 'alarm ' || e.number || ' acknowledged%')
    UNION ALL
    SELECT 'gaps', format('%s gaps, %s s without rows', count(*), sum(g.last - g.first + 1))
    FROM gyrotherm.gap g WHERE g.run = r.id HAVING count(*) > 0
    UNION ALL
    SELECT 'silent', format('%s; last row %s', r.state,
                            coalesce(to_char(gyrotherm.utc(r.last_utc_ns) AT TIME ZONE 'UTC',
                                             'YYYY-MM-DD"T"HH24:MI:SS"Z"'), 'none'))
    WHERE NOT r.finished AND r.state <> 'aborted'
      AND coalesce(gyrotherm.utc(r.last_utc_ns), r.started) < now() - interval '10 minutes'
    UNION ALL
    SELECT 'more rows than its record', format('%s rows here, %s in the record', r.rows, r.rows_in_record)
    WHERE r.rows > r.rows_in_record
  ) a;

-- Each rig, and what is on it: the run that began last, one of its own before those that it imported, and both before
-- virtual ones.
CREATE OR REPLACE VIEW gyrotherm.v1_rig AS
  SELECT g.name AS rig, g.owner, CASE WHEN r.finished THEN 'idle' ELSE r.state END AS state, r.profile, r.started,
         gyrotherm.utc(r.last_utc_ns) AS last_row,
         (SELECT string_agg(u.serial_number, ' ' ORDER BY u.label)
          FROM gyrotherm.run_unit u WHERE u.run = r.id) AS units,
         (SELECT count(*) FROM gyrotherm.run o WHERE o.rig = g.name) AS runs, r.id AS run, r.simulated
  FROM gyrotherm.rig g
  LEFT JOIN LATERAL (
    SELECT * FROM gyrotherm.run o WHERE o.rig = g.name
    ORDER BY o.simulated, o.imported, o.started DESC LIMIT 1) r ON true;

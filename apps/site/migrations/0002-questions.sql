-- SPDX-License-Identifier: Apache-2.0
-- What a site asks of its store: one view for each question of `gyrotherm site`. Columns of a view stay as they are;
-- more may come behind them. Nothing here writes, and rigs see none of it.

-- The reports that count: none that another one replaced, and of those of one unit and day with one number the
-- authorised one. A draft counts where nothing of that day is authorised.
CREATE VIEW gyrotherm.current_calibration AS
  SELECT c.* FROM gyrotherm.calibration c
  WHERE c.state <> 'superseded' AND NOT EXISTS (
    SELECT FROM gyrotherm.calibration o WHERE o.serial_number = c.serial_number AND o.model = c.model
      AND (o.state = 'superseded' AND o.number = c.number AND c.number <> ''
           OR o.state <> 'superseded' AND o.calibrated = c.calibrated AND (o.number = c.number OR c.state = 'draft')
              AND (o.state, o.sha256) < (c.state, c.sha256)));

-- Each result of a unit against the one before, made anew for a unit whenever a calibration of it comes, in whatever
-- order they do: asking for it costs nothing then.
CREATE TABLE gyrotherm.drift (
  sha256 text NOT NULL,
  number integer NOT NULL,
  serial_number text NOT NULL,
  model text NOT NULL,
  axis text NOT NULL,
  stage text NOT NULL,
  quantity text NOT NULL,
  condition text NOT NULL,
  unit text NOT NULL,
  calibrated date NOT NULL,
  value double precision,
  expanded_uncertainty double precision,
  calibrated_before date,
  value_before double precision,
  change double precision,
  e_n double precision,
  is_newest boolean NOT NULL,
  lot bigint NOT NULL, -- equal where model, axis, stage, quantity, condition and unit are
  PRIMARY KEY (sha256, number),
  FOREIGN KEY (sha256, number) REFERENCES gyrotherm.calibration_result (sha256, number)
);
CREATE INDEX ON gyrotherm.drift (serial_number);
CREATE INDEX ON gyrotherm.drift (abs(e_n) DESC NULLS LAST);
CREATE INDEX ON gyrotherm.drift (lot) INCLUDE (value) WHERE is_newest AND value IS NOT NULL;

-- As found is held against what the unit had been left with, so that the change is the drift of the compensated unit;
-- as left against as found of the same day is an adjustment, and no change. E_n = change / sqrt(U^2 + U_before^2) (ISO
-- 13528:2022, 9.7): beyond 1 the two do not agree.
CREATE FUNCTION gyrotherm.make_drift(a_serial_number text, a_model text) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM pg_advisory_xact_lock(hashtext('gyrotherm.make_drift'), hashtext(a_serial_number || ' ' || a_model));
  DELETE FROM gyrotherm.drift WHERE serial_number = a_serial_number AND model = a_model;
  INSERT INTO gyrotherm.drift
  SELECT sha256, result, serial_number, model, axis, stage, quantity, condition, unit, calibrated, value,
         expanded_uncertainty, calibrated_before, value_before, change,
         change / nullif(sqrt(expanded_uncertainty ^ 2 + uncertainty_before ^ 2), 0), calibrated = newest,
         hashtextextended(concat_ws('|', model, axis, stage, quantity, condition, unit), 0)
  FROM (
    SELECT *, CASE WHEN stage <> 'as_left' OR stage_before <> 'as_found' THEN value - value_before END AS change
    FROM (
      SELECT c.*, r.number AS result, r.axis, r.stage, r.quantity, r.condition, r.unit, r.value, r.expanded_uncertainty,
             lag(r.value) OVER series AS value_before, lag(r.expanded_uncertainty) OVER series AS uncertainty_before,
             lag(r.stage) OVER series AS stage_before, lag(c.calibrated) OVER series AS calibrated_before,
             max(c.calibrated) OVER () AS newest
      FROM gyrotherm.current_calibration c JOIN gyrotherm.calibration_result r USING (sha256)
      WHERE c.serial_number = a_serial_number AND c.model = a_model AND r.expanded_uncertainty IS NOT NULL
        AND NOT r.in_sample
      WINDOW series AS (PARTITION BY r.axis, r.stage = 'uncompensated', r.quantity, r.condition, r.unit
                        ORDER BY c.calibrated, r.stage, c.sha256)
    ) pairs
  ) changes;
END
$$;

CREATE FUNCTION gyrotherm.results_came() RETURNS trigger
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM gyrotherm.make_drift(u.serial_number, u.model)
  FROM (SELECT DISTINCT c.serial_number, c.model FROM came JOIN gyrotherm.calibration c USING (sha256)
        ORDER BY c.serial_number, c.model) u;
  RETURN NULL;
END
$$;
CREATE TRIGGER results_came AFTER INSERT ON gyrotherm.calibration_result REFERENCING NEW TABLE AS came
  FOR EACH STATEMENT EXECUTE FUNCTION gyrotherm.results_came();
SELECT gyrotherm.make_drift(serial_number, model) FROM gyrotherm.unit ORDER BY serial_number, model;

CREATE VIEW gyrotherm.v1_drift AS
  SELECT d.serial_number, d.model, d.axis, d.stage, d.quantity, d.condition, d.calibrated, d.value,
         d.expanded_uncertainty, d.unit, d.calibrated_before, d.value_before, d.change, d.e_n,
         d.change / nullif((d.calibrated - d.calibrated_before) / 365.25, 0) AS change_per_year, c.state, c.number,
         c.simulated
  FROM gyrotherm.drift d JOIN gyrotherm.calibration c USING (sha256);

-- Outliers: the newest result of each unit among all units of its model. z = 0.6745 (x - median) / MAD; beyond 3.5 it
-- is one (Iglewicz & Hoaglin 1993). Of fewer than five units nothing is said.
CREATE VIEW gyrotherm.v1_outlier AS
  WITH middle AS (
    SELECT lot, array_agg(value) AS numbers, percentile_cont(0.5) WITHIN GROUP (ORDER BY value) AS median
    FROM gyrotherm.drift WHERE is_newest AND value IS NOT NULL GROUP BY lot HAVING count(*) >= 5
  ), spread AS MATERIALIZED (
    SELECT lot, cardinality(numbers) AS units, median,
           (SELECT percentile_cont(0.5) WITHIN GROUP (ORDER BY abs(n - median)) FROM unnest(numbers) n) AS mad
    FROM middle
  )
  SELECT d.serial_number, d.model, d.axis, d.stage, d.quantity, d.condition, d.calibrated, d.value, d.unit, s.median,
         s.mad, 0.6745 * (d.value - s.median) / s.mad AS robust_z, s.units
  FROM spread s JOIN gyrotherm.drift d USING (lot)
  WHERE d.is_newest AND d.value IS NOT NULL AND s.mad > 0 AND abs(0.6745 * (d.value - s.median) / s.mad) > 3.5;

-- Thermometers and the day on which their calibration ends.
CREATE VIEW gyrotherm.v1_thermometer AS
  SELECT rig, name, instrument, certificate, calibrated, due, due - current_date AS days_left, started AS last_used
  FROM gyrotherm.thermometer;

-- Hours that a rig ran, by ISO week (its Monday, UTC); a run that goes on counts to its last row. Of imported runs
-- nobody knows where they ran.
CREATE VIEW gyrotherm.v1_utilisation AS
  SELECT r.rig, w.week::date AS week, count(*) AS runs, sum(t.seconds) / 3600 AS hours,
         sum(t.seconds) / 6048 AS percent, r.simulated
  FROM (SELECT rig, simulated, started AT TIME ZONE 'UTC' AS started,
               coalesce(gyrotherm.utc(last_utc_ns), started) AT TIME ZONE 'UTC' AS until
        FROM gyrotherm.run WHERE NOT imported) r
  CROSS JOIN LATERAL generate_series(date_trunc('week', r.started), r.until, interval '7 days') AS w(week)
  CROSS JOIN LATERAL (SELECT extract(epoch FROM least(r.until, w.week + interval '7 days')
                                            - greatest(r.started, w.week)) AS seconds) t
  GROUP BY r.rig, w.week, r.simulated;

-- Runs that somebody should look at, and why. An alarm is what an interlock did; it stands until an event acknowledges
-- its number (docs/interlocks.md). A run is silent where it is not finished and its last row is ten minutes old.
CREATE VIEW gyrotherm.v1_attention AS
  SELECT r.id AS run, r.rig, r.started, r.profile, a.what, a.detail, r.simulated
  FROM gyrotherm.run r
  CROSS JOIN LATERAL (
    SELECT 'aborted' AS what, r.cause AS detail WHERE r.state IN ('aborting', 'aborted')
    UNION ALL
    SELECT 'alarm', e.text FROM gyrotherm.event e
    WHERE e.run = r.id AND e.kind = 'interlock' AND e.reaction <> '' AND NOT EXISTS (
      SELECT FROM gyrotherm.event k WHERE k.run = r.id AND k.kind = 'acknowledged'
        AND k.text LIKE 'alarm ' || e.number || ' acknowledged%')
    UNION ALL
    SELECT 'gaps', format('%s gaps, %s s without rows', count(*), sum(g.last - g.first + 1))
    FROM gyrotherm.gap g WHERE g.run = r.id HAVING count(*) > 0
    UNION ALL
    SELECT 'silent', format('%s; last row %s', r.state,
                            coalesce(to_char(gyrotherm.utc(r.last_utc_ns) AT TIME ZONE 'UTC',
                                             'YYYY-MM-DD"T"HH24:MI:SS"Z"'), 'none'))
    WHERE NOT r.finished AND coalesce(gyrotherm.utc(r.last_utc_ns), r.started) < now() - interval '10 minutes'
    UNION ALL
    SELECT 'more rows than its record', format('%s rows here, %s in the record', r.rows, r.rows_in_record)
    WHERE r.rows > r.rows_in_record
  ) a;

-- Each rig, and what is on it: the run that began last.
CREATE VIEW gyrotherm.v1_rig AS
  SELECT g.name AS rig, g.owner, CASE WHEN r.finished THEN 'idle' ELSE r.state END AS state, r.profile, r.started,
         gyrotherm.utc(r.last_utc_ns) AS last_row,
         (SELECT string_agg(u.serial_number, ' ' ORDER BY u.label)
          FROM gyrotherm.run_unit u WHERE u.run = r.id) AS units,
         (SELECT count(*) FROM gyrotherm.run o WHERE o.rig = g.name) AS runs, r.id AS run, r.simulated
  FROM gyrotherm.rig g
  LEFT JOIN LATERAL (
    SELECT * FROM gyrotherm.run o WHERE o.rig = g.name ORDER BY o.finished, o.started DESC LIMIT 1) r ON true;

GRANT SELECT ON ALL TABLES IN SCHEMA gyrotherm TO gyrotherm_analyst;

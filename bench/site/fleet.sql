-- SPDX-License-Identifier: Apache-2.0
-- Fills an empty store with a synthetic site: 200 units of four models on ten rigs, each calibrated twice a year for
-- five years, as found and as left, with runs, events, gaps and thermometers. setseed() makes drift, spread and
-- outliers reproducible. Must be run by the owner of the store.
SELECT setseed(0.25);
BEGIN;

INSERT INTO gyrotherm.rig SELECT 'rig-' || r, 'gyrotherm_owner' FROM generate_series(1, 10) r;

-- Two runs per calibration, one day each.
CREATE TEMP TABLE visit AS
  SELECT u, v, to_char(u, 'FM0000') AS serial, 'RLG-' || u % 4 AS model, 'rig-' || u % 10 + 1 AS rig,
         timestamptz '2021-01-04 08:00Z' + (v * 182 + u % 20 * 9) * interval '1 day'
           + u / 20 * interval '4 hours' AS at,
         sum(random() - 0.5) OVER (PARTITION BY u ORDER BY v) AS walk, random() < 0.02 AS is_outlier
  FROM generate_series(1, 200) u, generate_series(0, 9) v;

INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info, state, rows, last_slot,
                          last_utc_ns, heard, finished, ended, rows_in_record)
  SELECT gen_random_uuid(), rig, 'gyrotherm_owner', at + n * interval '1 day',
         CASE n WHEN 0 THEN 'qualification' ELSE 'random' END, false, false, '{}',
         CASE WHEN random() < 0.01 THEN 'aborted' ELSE 'complete' END, 79200, 79199,
         extract(epoch FROM at + n * interval '1 day' + interval '22 hours')::bigint * 1000000000,
         at + n * interval '1 day' + interval '22 hours', random() < 0.999,
         at + n * interval '1 day' + interval '22 hours', 79200
  FROM visit, generate_series(0, 1) n;
INSERT INTO gyrotherm.run_unit
  SELECT DISTINCT ON (r.id) r.id, 'gyro', v.serial, v.model FROM gyrotherm.run r
  JOIN visit v ON v.rig = r.rig AND r.started >= v.at AND r.started < v.at + interval '2 days' ORDER BY r.id, v.at DESC;
INSERT INTO gyrotherm.event
  SELECT r.id, n, n * 1000, 0, CASE WHEN n = 7 AND random() < 0.03 THEN 'interlock' ELSE 'segment' END, NULL,
         CASE WHEN n = 7 THEN 'hold' END, n, NULL, 'segment ' || n
  FROM gyrotherm.run r, generate_series(1, 30) n;
INSERT INTO gyrotherm.gap SELECT id, 100, 190, 'power cut' FROM gyrotherm.run WHERE random() < 0.02;
INSERT INTO gyrotherm.thermometer
  SELECT rig, chr(64 + n), 'lakeshore_218 1', 'T-' || n, date '2025-06-01', date '2026-06-01' + n * 20,
         max(id::text)::uuid, max(started)
  FROM gyrotherm.run, generate_series(1, 16) n GROUP BY rig, n;

INSERT INTO gyrotherm.document
  SELECT md5(u || ':' || v), 'calibration', 'gyrotherm-calibration/1', 'calibration.json', rig, 'gyrotherm_owner', '{}'
  FROM visit;
INSERT INTO gyrotherm.calibration
  SELECT md5(u || ':' || v), serial, model, 'C-' || u || '-' || v, 'authorised', false, at::date, at::date + 5
  FROM visit;
-- Twelve quantities of three axes in two or three stages.
INSERT INTO gyrotherm.calibration_result
  SELECT md5(u || ':' || v), row_number() OVER (PARTITION BY u, v), axis, stage, quantity, 'qualification',
         q * 0.1 + u % 7 * 0.002 + CASE stage WHEN 'as_left' THEN 0.1 ELSE 1 END * walk * 0.01
           + (random() - 0.5) * 0.004 + CASE WHEN is_outlier THEN 0.5 ELSE 0 END,
         0.002, 0.004, '°/h', false
  FROM visit, unnest(ARRAY['x', 'y', 'z']) axis, unnest(ARRAY['uncompensated', 'as_found', 'as_left']) stage,
       unnest(ARRAY['whole_run.mean', 'whole_run.std', 'whole_run.rmse', 'hysteresis.width', 'stabilised_bias.bias',
                    'two_position.bias', 'retrace.change', 'angle_random_walk.angle_random_walk',
                    'bias_instability.bias_instability', 'ramp_sensitivity.ramp_sensitivity',
                    'gradient_sensitivity.gradient_sensitivity', 'coverage.seen_share'])
         WITH ORDINALITY AS t(quantity, q)
  WHERE stage <> 'as_found' OR v > 0;
COMMIT;
ANALYZE;

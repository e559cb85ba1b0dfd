-- SPDX-License-Identifier: Apache-2.0
-- Figures of unit types: yield, capability (Cpk) and the date of the next calibration, from calibration results and the
-- limits of their reports (docs/site.md#figures-of-types).

-- Functions of statistics. They return NULL outside of their domain, so no data can make a view fail.

-- ln Γ(x) for x > 0, to 2e-10 (Lanczos; Press et al., Numerical Recipes, 3rd ed., 6.1).
CREATE FUNCTION gyrotherm.log_gamma(x double precision) RETURNS double precision
LANGUAGE sql IMMUTABLE STRICT PARALLEL SAFE
RETURN -(x + 5.5) + (x + 0.5) * ln(x + 5.5) + ln(2.5066282746310005 * (1.000000000190015
  + 76.18009172947146 / (x + 1) - 86.50532032941677 / (x + 2) + 24.01409824083091 / (x + 3)
  - 1.231739572450155 / (x + 4) + 0.1208650973866179e-2 / (x + 5) - 0.5395239384953e-5 / (x + 6)) / x);

-- Regularised incomplete beta function I_x(a, b) by Lentz's continued fraction (Numerical Recipes, 6.4).
CREATE FUNCTION gyrotherm.beta_probability(a double precision, b double precision, x double precision)
RETURNS double precision
LANGUAGE plpgsql IMMUTABLE STRICT PARALLEL SAFE SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  turned boolean := x > (a + 1) / (a + b + 2); -- the fraction converges fast only below this
  p double precision := CASE WHEN turned THEN b ELSE a END;
  q double precision := CASE WHEN turned THEN a ELSE b END;
  y double precision := CASE WHEN turned THEN 1 - x ELSE x END;
  tiny CONSTANT double precision := 1e-300;
  c double precision := 1;
  d double precision;
  factor double precision;
  fraction double precision;
  term double precision;
BEGIN
  IF NOT (a > 0 AND b > 0 AND a < 1e7 AND b < 1e7 AND x BETWEEN 0 AND 1) THEN RETURN NULL; END IF;
  IF x IN (0, 1) THEN RETURN x; END IF;
  d := 1 - (p + q) * y / (p + 1);
  IF abs(d) < tiny THEN d := tiny; END IF;
  d := 1 / d;
  fraction := d;
  FOR m IN 1..10000 LOOP
    term := m * (q - m) * y / ((p + 2 * m - 1) * (p + 2 * m));
    d := 1 + term * d;
    IF abs(d) < tiny THEN d := tiny; END IF;
    c := 1 + term / c;
    IF abs(c) < tiny THEN c := tiny; END IF;
    d := 1 / d;
    fraction := fraction * d * c;
    term := -(p + m) * (p + q + m) * y / ((p + 2 * m) * (p + 2 * m + 1));
    d := 1 + term * d;
    IF abs(d) < tiny THEN d := tiny; END IF;
    c := 1 + term / c;
    IF abs(c) < tiny THEN c := tiny; END IF;
    d := 1 / d;
    factor := d * c;
    fraction := fraction * factor;
    EXIT WHEN abs(factor - 1) < 1e-14;
  END LOOP;
  -- exp() of a double fails on underflow
  fraction := fraction / p * exp(greatest(-700, gyrotherm.log_gamma(a + b) - gyrotherm.log_gamma(a)
                                                - gyrotherm.log_gamma(b) + p * ln(y) + q * ln(1 - y)));
  RETURN CASE WHEN turned THEN 1 - fraction ELSE fraction END;
END
$$;

-- The x with I_x(a, b) = probability, by bisection to 2^-52.
CREATE FUNCTION gyrotherm.beta_quantile(a double precision, b double precision, probability double precision)
RETURNS double precision
LANGUAGE plpgsql IMMUTABLE STRICT PARALLEL SAFE SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  low double precision := 0;
  high double precision := 1;
  middle double precision;
BEGIN
  IF NOT (a > 0 AND b > 0 AND probability BETWEEN 0 AND 1) THEN RETURN NULL; END IF;
  FOR i IN 1..52 LOOP
    middle := (low + high) / 2;
    IF gyrotherm.beta_probability(a, b, middle) < probability THEN low := middle; ELSE high := middle; END IF;
  END LOOP;
  RETURN (low + high) / 2;
END
$$;

-- Quantile of Student's distribution for a probability from 0.5 to 1: T² / (ν + T²) follows a beta distribution.
CREATE FUNCTION gyrotherm.student_quantile(freedom double precision, probability double precision)
RETURNS double precision
LANGUAGE sql IMMUTABLE STRICT PARALLEL SAFE
RETURN CASE WHEN freedom > 0 AND probability >= 0.5 AND probability < 1
            THEN (SELECT sqrt(freedom * x / (1 - x))
                  FROM (SELECT gyrotherm.beta_quantile(0.5, freedom / 2, 2 * probability - 1) AS x) b) END;

-- Limits

-- The limits of a report with the result that was compared with each: the members of `conformity`. A limit applies to
-- the magnitude of a result. Numbers with which a view could not calculate are missing.
CREATE TABLE gyrotherm.calibration_limit (
  sha256 text NOT NULL REFERENCES gyrotherm.calibration,
  number integer NOT NULL,
  axis text NOT NULL,
  stage text NOT NULL,
  quantity text NOT NULL, -- KEY.QUANTITY
  unit text NOT NULL,
  at_most double precision NOT NULL CHECK (at_most BETWEEN 1e-100 AND 1e100),
  verdict text NOT NULL, -- pass, conditional_pass, conditional_fail, not_known, fail
  PRIMARY KEY (sha256, number)
);
CREATE INDEX ON gyrotherm.calibration_limit (quantity, stage);

CREATE FUNCTION gyrotherm.read_limits(a_sha256 text) RETURNS void
LANGUAGE sql SET search_path = pg_catalog, pg_temp AS $$
  INSERT INTO gyrotherm.calibration_limit(sha256, number, axis, stage, quantity, unit, at_most, verdict)
  SELECT a_sha256, l.n, coalesce(l.value->>'axis', ''), coalesce(l.value->>'stage', ''), l.value->>'quantity',
         coalesce(l.value->>'unit', ''), (l.value->>'limit')::double precision, coalesce(l.value->>'verdict', '')
  FROM gyrotherm.document d,
    jsonb_array_elements(CASE WHEN jsonb_typeof(d.text::jsonb->'conformity') = 'array'
                              THEN d.text::jsonb->'conformity' ELSE '[]' END) WITH ORDINALITY AS l(value, n)
  WHERE d.sha256 = a_sha256 AND jsonb_typeof(l.value->'limit') = 'number' AND l.value->>'quantity' <> ''
    AND (l.value->>'limit')::numeric BETWEEN 1e-100 AND 1e100
  ON CONFLICT DO NOTHING;
$$;

CREATE FUNCTION gyrotherm.calibration_came() RETURNS trigger
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM gyrotherm.read_limits(NEW.sha256);
  RETURN NULL;
END
$$;
CREATE TRIGGER calibration_came AFTER INSERT ON gyrotherm.calibration
  FOR EACH ROW EXECUTE FUNCTION gyrotherm.calibration_came();
SELECT gyrotherm.read_limits(sha256) FROM gyrotherm.calibration;

-- The newest calibration of each unit that is neither a draft nor superseded.
CREATE VIEW gyrotherm.newest_calibration AS
  SELECT DISTINCT ON (serial_number, model, simulated) *
  FROM gyrotherm.current_calibration WHERE state <> 'draft'
  ORDER BY serial_number, model, simulated, calibrated DESC, number DESC, sha256;

-- Yield: the part of the units of a model that meet their limits, by their newest calibrations. A unit passes if every
-- verdict is pass or conditional_pass. Units with an unknown verdict and without a failed one are undecided and do not
-- count. The interval is that of Clopper and Pearson (Biometrika 26 (1934) 404; ISO 16269-6 has the same limits), 95 %.
CREATE VIEW gyrotherm.v1_yield AS
  WITH judged AS (
    SELECT c.model, c.simulated, l.sha256, l.quantity, l.verdict
    FROM gyrotherm.newest_calibration c JOIN gyrotherm.calibration_limit l USING (sha256)
    UNION ALL
    SELECT c.model, c.simulated, l.sha256, 'all limits', l.verdict
    FROM gyrotherm.newest_calibration c JOIN gyrotherm.calibration_limit l USING (sha256)
  ), by_unit AS (
    SELECT model, simulated, quantity, sha256, bool_or(verdict IN ('fail', 'conditional_fail')) AS failed,
           bool_and(verdict IN ('pass', 'conditional_pass')) AS passed
    FROM judged GROUP BY model, simulated, quantity, sha256
  ), counted AS (
    SELECT model, simulated, quantity, count(*) FILTER (WHERE passed OR failed) AS units,
           count(*) FILTER (WHERE passed) AS passed, count(*) FILTER (WHERE NOT passed AND NOT failed) AS undecided
    FROM by_unit GROUP BY model, simulated, quantity
  )
  SELECT model, quantity, units, passed, undecided, passed::double precision / nullif(units, 0) AS yield,
         CASE WHEN units = 0 THEN NULL WHEN passed = 0 THEN 0
              ELSE gyrotherm.beta_quantile(passed, units - passed + 1, 0.025) END AS low,
         CASE WHEN units = 0 THEN NULL WHEN passed = units THEN 1
              ELSE gyrotherm.beta_quantile(passed + 1, units - passed, 0.975) END AS high,
         simulated
  FROM counted;

-- Capability: Cpk = min(limit - mean, mean + limit) / (3 s) of a result over the units of a model, by their newest
-- calibrations (ISO 22514-2; Montgomery, Introduction to Statistical Quality Control, 6th ed., 8.2). A limit applies to
-- the magnitude, so the specification is -limit to +limit; for a result that is never negative, such as an RMSE, this
-- is the upper limit alone. The interval is Bissell's approximation, 95 % (Applied Statistics 39 (1990) 331; Montgomery,
-- 8.3.4). It assumes a normal distribution. s contains the measurement uncertainty. At least five units; in-sample
-- results do not count. Units whose reports have different limits are counted separately.
CREATE VIEW gyrotherm.v1_capability AS
  WITH limited AS (
    SELECT c.model, c.simulated, r.axis, r.stage, r.quantity, r.condition, r.unit, l.at_most, r.value,
           row_number() OVER (PARTITION BY c.sha256, r.axis, r.stage, r.quantity, r.condition, r.unit, l.at_most
                              ORDER BY r.number) AS again
    FROM gyrotherm.newest_calibration c
    JOIN gyrotherm.calibration_result r USING (sha256)
    JOIN (SELECT DISTINCT sha256, axis, stage, quantity, at_most FROM gyrotherm.calibration_limit) l
      ON l.sha256 = r.sha256 AND l.axis = r.axis AND l.stage = r.stage AND l.quantity = r.quantity
    WHERE r.value IS NOT NULL AND NOT r.in_sample
  ), pooled AS (
    SELECT model, simulated, axis, stage, quantity, condition, unit, at_most, count(*) AS units, avg(value) AS mean,
           stddev_samp(value) AS s
    FROM limited WHERE again = 1
    GROUP BY model, simulated, axis, stage, quantity, condition, unit, at_most HAVING count(*) >= 5
  ), capable AS (
    -- Without the bound, a hostile report could make the square of cpk overflow.
    SELECT *, CASE WHEN s > 1e-12 * greatest(at_most, abs(mean)) THEN (at_most - abs(mean)) / (3 * s) END AS cpk
    FROM pooled
  )
  SELECT model, axis, stage, quantity, condition, units, mean, s, at_most AS "limit", unit, cpk,
         cpk - width AS low, cpk + width AS high, simulated
  FROM capable
  CROSS JOIN LATERAL (SELECT 1.959963984540054 * sqrt(1 / (9.0 * units) + cpk ^ 2 / (2.0 * (units - 1))) AS width) w;

-- The day until which a result of a unit remains within its limit with a probability of 95 %, for each result with a
-- limit. The drift is that between successive calibrations, the as-found result against the previous as-left one
-- (v1_drift). Model: Brownian motion with drift. With the changes D and times T of the periods,
-- d = sum(D) / sum(T), s² = sum((D - d T)² / T) / (periods - 1). The result x with its standard uncertainty u exceeds
-- the limit with the probability 5 % at the first t with |x ± d t| + t95(periods - 1) sqrt(s² t (1 + t/sum(T)) + u²) =
-- limit. s contains the uncertainty of the measurement, so the day is early rather than late. Rules: control chart over
-- calendar time (ILAC-G24:2022, method 2), reliability target 95 % (NCSLI RP-1). At least three calibrations.
CREATE VIEW gyrotherm.v1_recalibration AS
  WITH period AS (
    -- Bounds keep the squares finite and above 0, also for hostile reports.
    SELECT d.serial_number, d.model, c.simulated, d.axis, d.stage = 'uncompensated' AS is_raw, d.quantity, d.condition,
           d.unit, CASE WHEN abs(d.change) < 1e-60 THEN 0 ELSE d.change END AS change,
           (d.calibrated - d.calibrated_before) / 365.25::double precision AS years
    FROM gyrotherm.drift d JOIN gyrotherm.calibration c USING (sha256)
    WHERE abs(d.change) < 1e60 AND d.calibrated > d.calibrated_before
  ), fitted AS (
    SELECT serial_number, model, simulated, axis, is_raw, quantity, condition, unit, count(*) AS periods,
           sum(years) AS years, sum(change) / sum(years) AS drift,
           sum(change ^ 2 / years) - sum(change) ^ 2 / sum(years) AS squares
    FROM period GROUP BY serial_number, model, simulated, axis, is_raw, quantity, condition, unit
  ), now AS (
    -- The state in which the unit left the laboratory: as left, or uncompensated.
    SELECT DISTINCT ON (c.sha256, r.axis, r.stage, r.quantity, r.condition, r.unit)
           c.serial_number, c.model, c.simulated, r.axis, r.stage = 'uncompensated' AS is_raw, r.stage, r.quantity,
           r.condition, r.unit, c.calibrated, r.value, r.standard_uncertainty AS u, l.at_most
    FROM gyrotherm.newest_calibration c
    JOIN gyrotherm.calibration_result r USING (sha256)
    JOIN gyrotherm.calibration_limit l
      ON l.sha256 = r.sha256 AND l.axis = r.axis AND l.stage = r.stage AND l.quantity = r.quantity
    WHERE r.stage IN ('as_left', 'uncompensated') AND r.value IS NOT NULL AND r.standard_uncertainty IS NOT NULL
      AND NOT r.in_sample AND l.at_most BETWEEN 1e-30 AND 1e30
    ORDER BY c.sha256, r.axis, r.stage, r.quantity, r.condition, r.unit, l.at_most
  ), joined AS MATERIALIZED (
    -- In units of the limit from here on; less than 1e-12 of it is 0, and more than 1e12 times exceeds it.
    SELECT n.*, coalesce(f.periods, 0) AS periods, f.drift, f.years, n.value / n.at_most AS x,
           n.u / n.at_most AS relative_u, f.drift / n.at_most AS speed,
           greatest(f.squares, 0) / nullif(f.periods - 1, 0) / n.at_most ^ 2 AS s2,
           CASE WHEN f.periods >= 2 THEN gyrotherm.student_quantile(f.periods - 1, 0.95) END AS t
    FROM now n LEFT JOIN fitted f USING (serial_number, model, simulated, axis, is_raw, quantity, condition, unit)
  ), scaled AS (
    SELECT *, greatest(abs(x), relative_u, abs(speed), sqrt(s2)) > 1e12 AS is_far,
           CASE WHEN abs(x) BETWEEN 1e-12 AND 1e12 THEN x ELSE 0 END AS x0,
           CASE WHEN relative_u BETWEEN 1e-12 AND 1e12 THEN relative_u ELSE 0 END AS u0,
           CASE WHEN abs(speed) BETWEEN 1e-12 AND 1e12 THEN speed ELSE 0 END AS d0,
           CASE WHEN s2 BETWEEN 1e-24 AND 1e24 THEN s2 ELSE 0 END AS v0
    FROM joined
  ), crossed AS (
    SELECT s.*, CASE WHEN s.t IS NULL THEN NULL WHEN s.is_far THEN 0 ELSE (
      SELECT min(CASE WHEN gap <= t * u0 THEN 0 ELSE (
        -- (gap - d τ)² = t² (s² τ (1 + τ / years) + u²): the smallest positive root of a τ² + b τ + c = 0
        SELECT min(root) FROM unnest(CASE WHEN b ^ 2 >= 4 * a * c
                                          THEN ARRAY[2 * c / nullif(-b + sqrt(b ^ 2 - 4 * a * c), 0),
                                                     2 * c / nullif(-b - sqrt(b ^ 2 - 4 * a * c), 0)] END) AS root
        WHERE root > 0) END)
      FROM (VALUES (1 - x0, d0), (1 + x0, -d0)) AS side(gap, d)
      CROSS JOIN LATERAL (SELECT d ^ 2 - t ^ 2 * v0 / years AS a, -2 * gap * d - t ^ 2 * v0 AS b,
                                 gap ^ 2 - t ^ 2 * u0 ^ 2 AS c) quadratic) END AS years_left
    FROM scaled s
  )
  SELECT serial_number, model, axis, stage, quantity, condition, periods + 1 AS calibrations, calibrated, value,
         u AS standard_uncertainty, at_most AS "limit", unit, drift AS drift_per_year, years_left,
         CASE WHEN years_left < 20 THEN calibrated + floor(years_left * 365.25)::integer END AS due,
         CASE WHEN periods < 2 THEN 'fewer than three calibrations'
              WHEN years_left = 0 THEN 'not within the limit with 95 % now'
              WHEN years_left IS NULL OR years_left >= 20 THEN 'later than 20 years' ELSE '' END AS note, simulated
  FROM crossed;

-- The planner expects many rows in the arrays of a report, and would compile its queries for seconds.
ALTER FUNCTION gyrotherm.add_document(text, text, text, text) SET jit = off;

REVOKE ALL ON FUNCTION gyrotherm.log_gamma(double precision),
  gyrotherm.beta_probability(double precision, double precision, double precision),
  gyrotherm.beta_quantile(double precision, double precision, double precision),
  gyrotherm.student_quantile(double precision, double precision), gyrotherm.read_limits(text),
  gyrotherm.calibration_came() FROM PUBLIC;
GRANT EXECUTE ON FUNCTION gyrotherm.log_gamma(double precision),
  gyrotherm.beta_probability(double precision, double precision, double precision),
  gyrotherm.beta_quantile(double precision, double precision, double precision),
  gyrotherm.student_quantile(double precision, double precision) TO gyrotherm_analyst;
GRANT SELECT ON gyrotherm.calibration_limit, gyrotherm.newest_calibration, gyrotherm.v1_yield,
  gyrotherm.v1_capability, gyrotherm.v1_recalibration TO gyrotherm_analyst;

-- SPDX-License-Identifier: Apache-2.0
-- A result that depends on the zero of the bias says it in its condition, so that drift and outliers compare results of
-- one zero. The mean of a record's first hold is a zero of that run alone, and no other run is compared with it.

-- Adds the zero to the conditions of a report's results. Reports that say no zero stay as they are.
CREATE FUNCTION gyrotherm.name_zeros(a_sha256 text) RETURNS void
LANGUAGE sql SET search_path = pg_catalog, pg_temp AS $$
  WITH report AS (
    SELECT text::jsonb AS d FROM gyrotherm.document WHERE sha256 = a_sha256
  ), own AS (
    SELECT z->>'axis' AS axis, z->>'run' AS run, z->>'zero' AS zero
    FROM report, jsonb_array_elements(d->'bias_zeros') AS z
  ), counted AS (
    SELECT row_number() OVER (ORDER BY r.n, c.n, v.n) AS number, r.value->>'axis' AS axis, r.value->>'run' AS run,
           c.value->>'quantity' IN ('bias', 'mean', 'rmse', 'largest', 'compensated_bias') AS depends_on_it,
           d->>'bias_zero' AS zero
    FROM report, jsonb_array_elements(d->'results') WITH ORDINALITY AS r(value, n),
      jsonb_array_elements(r.value->'columns') WITH ORDINALITY AS c(value, n),
      jsonb_array_elements(c.value->'values') WITH ORDINALITY AS v(value, n)
  ), named AS (
    SELECT number, counted.run, coalesce(own.zero, nullif(counted.zero, '')) AS zero
    FROM counted LEFT JOIN own USING (axis, run) WHERE depends_on_it
  )
  UPDATE gyrotherm.calibration_result r
  SET condition = concat_ws(', ', nullif(r.condition, ''), n.zero,
                            CASE WHEN n.zero = 'mean of the first hold removed' THEN 'run ' || n.run END)
  FROM named n WHERE r.sha256 = a_sha256 AND r.number = n.number AND n.zero IS NOT NULL;
$$;
REVOKE ALL ON FUNCTION gyrotherm.name_zeros(text) FROM public;

CREATE OR REPLACE FUNCTION gyrotherm.results_came() RETURNS trigger
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM gyrotherm.name_zeros(sha256) FROM (SELECT DISTINCT sha256 FROM came) c;
  PERFORM gyrotherm.make_drift(u.serial_number, u.model)
  FROM (SELECT DISTINCT c.serial_number, c.model FROM came JOIN gyrotherm.calibration c USING (sha256)
        ORDER BY c.serial_number, c.model) u;
  RETURN NULL;
END
$$;

SELECT gyrotherm.name_zeros(sha256) FROM gyrotherm.calibration;
SELECT gyrotherm.make_drift(serial_number, model) FROM gyrotherm.unit ORDER BY serial_number, model;

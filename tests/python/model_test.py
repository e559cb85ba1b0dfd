# SPDX-License-Identifier: Apache-2.0
"""Predictions equal the program's for each method and each kind of input, to 1e-12 of the bias' STD in training. The
tolerance is larger if the sum of the function's weights exceeds 1000 (docs/files.md)."""

import json
import re
import sqlite3
import unittest

from program import FolderTest, gyrotherm, record

import numpy as np
import pandas as pd

import gyrotherm as module
from gyrotherm.functions import variance_from_json

IMPORT_MAP = """schema = "gyrotherm-import/1"
name = "foreign"
title = "A foreign table"
[file]
separator = ","
header = true
[time]
column = "ms"
unit = "ms"
[[thermometer]]
name = "one"
column = "T1"
[[thermometer]]
name = "two"
column = "T2"
[gyro]
column = "rate"
kind = "rate"
scale = 0.5
[analysis]
gradients = ["one", "two"]
"""
TERMS = "A,rate:A,lag:600:B,A^2,A^3,A-B^2,A*rate:A,A*A-B,lag:600:A*A*rate:B"


def methods():
    """Returns all methods that `train --help` lists."""
    return re.search(r"--method METHOD:\{([a-z,-]+)\}", gyrotherm("train", "--help"))[1].split(",")


class Predictions(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.path = record(cls.folder / "run.db")

    def predicted(self, model, path, *options):
        """Returns the program's prediction for each second: raw bias minus the result of `export --compensated`."""
        out = model.with_suffix(".csv")
        gyrotherm("export", path, "--compensated", "--model", model, "--out", out, "--force", "--unverified", *options)
        table = pd.read_csv(out, comment="#", float_precision="round_trip", index_col="time [s]")
        table.index -= 1  # a second is sampled at its end
        return table["bias [°/h]"] - table["compensated [°/h]"]

    def agree(self, path, file):
        run, model = module.open(path), module.load_model(file)
        program, ours = self.predicted(file, path), model.predict(run)
        allowed = model.rounding_deg_per_h + 4 * np.finfo(float).eps * np.abs(run.axis().bias_deg_per_h).max()
        np.testing.assert_array_equal(program.isna(), ours.isna())
        self.assertGreater(ours.notna().sum(), len(ours) / 2)
        self.assertLess((program - ours).abs().max(), allowed, file)
        clusters = run.clusters()  # the prediction at the last second of a cluster is for the mean of the cluster
        means = model.predict(clusters)
        inputs, time = model.inputs_of(run)
        seconds = pd.Series(model.predict_inputs(inputs), index=time)  # not extrapolated, unlike streamed means
        at_ends = seconds.loc[clusters.start_s + clusters.length_s - 1].to_numpy()
        self.assertLess(np.nanmax(np.abs(means - at_ends)), 100 * allowed, file)  # means are summed in another order
        residual = module.figures(clusters.bias_deg_per_h - means)
        verified = json.loads(gyrotherm("verify", file, path, "--json", "--unverified"))["compensated"]
        for key, value in (("std_deg_per_h", residual.std), ("rmse_deg_per_h", residual.rmse)):
            self.assertLess(abs(verified[key] - value), allowed, (file, key))
        self.assertEqual(verified["count"], residual.count)

    def train(self, path, name, *words):
        file = self.folder / f"{name}.json"
        gyrotherm("train", path, "--quick", "--threads", 1, "--out", file, *words)
        return file

    def test_predicts_with_each_method(self):
        names = methods()
        self.assertGreaterEqual(len(names), 14)
        forms = set()
        for name in names:
            with self.subTest(name):
                file = self.train(self.path, name, "--method", name)
                forms.add(module.load_model(file).function.form)
                self.agree(self.path, file)
        self.assertEqual(forms, {"svr", "linear", "expansion", "network"})

    def test_predicts_with_each_kind_of_input(self):
        self.agree(self.path, self.train(self.path, "terms", "--method", "linear", "--inputs", TERMS))

    def test_predicts_imported_record(self):
        """The file has two rows per second, and some are missing."""
        rows = ["ms,T1,T2,rate"]
        for k in range(0, 8000):
            if not 3000 < k < 3450:
                t1, t2 = 20 + 10 * np.sin(k / 700), 21 + 10 * np.sin((k - 150) / 700)
                rows.append(f"{500 * k + k % 3},{t1:.4f},{t2:.4f},{1000 * np.cos(t1) + k % 7:.3f}")
        (self.folder / "foreign.csv").write_text("\n".join(rows) + "\n")
        (self.folder / "map.toml").write_text(IMPORT_MAP)
        path = self.folder / "foreign.db"
        gyrotherm("import", self.folder / "foreign.csv", "--map", self.folder / "map.toml", "--out", path)
        file = self.train(path, "imported", "--method", "rbfnn", "--inputs", "one,rate:two,lag:300:one")
        run, model = module.open(path), module.load_model(file)
        self.assertTrue(run.info.imported)
        self.assertEqual(len(run.to_pandas()), len(rows) - 1)
        clusters = run.clusters()
        residual = module.figures(clusters.bias_deg_per_h - model.predict(clusters))
        verified = json.loads(gyrotherm("verify", file, path, "--json"))["compensated"]
        self.assertEqual(verified["count"], residual.count)
        self.assertLess(abs(verified["rmse_deg_per_h"] - residual.rmse), 1e-12 * model.target_std_deg_per_h)
        with self.assertRaisesRegex(module.RecordError, "no grid of seconds"):
            model.predict(run)

    def test_names_dead_thermometer(self):
        path = record(self.folder / "dead.db")
        database = sqlite3.connect(path)
        database.execute("UPDATE sample SET B = NULL")
        database.commit()
        database.close()
        with self.assertRaisesRegex(module.RecordError, "no complete cluster of 100 s; no row has a value of B$"):
            module.open(path).clusters()

    def test_predicts_with_values_of_unit(self):
        mixed = record(self.folder / "mixed.db", rig="virtual-mixed")
        database = sqlite3.connect(mixed)  # the gyro's temperature is constant in this record
        database.execute('UPDATE sample SET "gyro.temperature" = round(A + 0.3 * B)')
        database.execute('UPDATE sample SET "gyro.acceleration_x" = slot % 977')
        database.execute("""UPDATE sample SET "gyro.temperature" = NULL WHERE slot BETWEEN 2050 AND 2060""")
        database.commit()
        database.close()
        run = module.open(mixed)
        self.assertEqual(run.clusters().names[-4:], ("aux:acceleration_z", "self", "aux:frames", "aux:flagged"))
        self.agree(mixed, self.train(mixed, "own", "--unverified", "--method", "ridge-u", "--inputs",
                                     "self,aux:acceleration_x,rate:self,lag:300:self,self*A"))

    def test_predicts_outside_trained_range(self):
        run = module.open(self.path)
        for method, inputs in (("linear", "A,B"), ("gp", "A,B,A*B"), ("ls-svm", "A,A-B")):
            file = self.train(self.path, f"part-{method}", "--method", method, "--inputs", inputs, "--clusters", "0:60",
                              "--quick")
            model, predictions = module.load_model(file), {}
            for outside in ("continue", "refuse", "extrapolate"):
                program, predictions[outside] = self.predicted(file, self.path, "--outside", outside), model.predict(run, outside)
                np.testing.assert_array_equal(program.isna(), predictions[outside].isna())
                self.assertLess((program - predictions[outside]).abs().max(),
                                model.rounding_deg_per_h + 1e-12 * model.target_std_deg_per_h, (method, outside))
            same = np.array_equal(predictions["continue"], predictions["extrapolate"], equal_nan=True)
            self.assertEqual(same, method == "linear", "a linear model has no part but the linear one")
            table = pd.read_csv(file.with_suffix(".csv"), comment="#", float_precision="round_trip")
            ours = model.expanded_uncertainty(run)
            self.assertGreater(ours.max(), model.uncertainty().expanded_deg_per_h, "larger outside the trained range")
            self.assertLess((table.iloc[:, -1].to_numpy() - ours.to_numpy())[~np.isnan(ours)].__abs__().max(), 1e-12)

    def test_predicts_from_frames_and_datasets(self):
        file = self.train(self.path, "frame", "--method", "linear", "--inputs", "A,A-B")
        run, model = module.open(self.path), module.load_model(file)
        for seconds in (run.to_pandas(), run.to_xarray()):
            np.testing.assert_array_equal(model.predict(seconds), model.predict(run))
        with self.assertRaisesRegex(module.ModelError, 'no column "A"'):
            model.predict(run.to_pandas()[["B"]])

    def test_budget_equals_that_of_program(self):
        file = self.train(self.path, "budget", "--method", "gp")
        model = module.load_model(file)
        combined = model.json["uncertainty"]["combined"]
        uncertainty = model.uncertainty(model.json["uncertainty"]["averaging_s"])
        self.assertAlmostEqual(uncertainty.expanded_deg_per_h, combined["U_deg_per_h"], delta=1e-12)
        self.assertAlmostEqual(uncertainty.coverage_factor, combined["k"], delta=1e-9)
        out = self.folder / "budget.csv"
        gyrotherm("export", self.path, "--compensated", "--model", file, "--out", out)
        last = pd.read_csv(out, comment="#", float_precision="round_trip").iloc[:, -1].dropna()
        self.assertAlmostEqual(model.uncertainty().expanded_deg_per_h, last.iloc[0], delta=1e-12)
        self.assertTrue((model.predict_std(module.open(self.path).clusters()).dropna() > 0).all())

    def test_variance_of_gaussian_process_equals_formula(self):
        """One centre c = 1 of one input, l = 2, σ_f = 3, S = [[a, 0], [0, s]], L² = 9 + 1e-9: k = 9 exp(−(z − 1)²/8), w
        = k/L, and the variance a z² + s w² + 9 − w²."""
        root = np.sqrt(9 + 1e-9)
        at = variance_from_json({"lengths": [2], "signal": 3, "noise": 0.1, "centres": [[1]], "root": [[root]],
                                 "posterior": [[0.5, 0], [0, 0.25]]}, 1)
        z = np.array([[-1.0], [0.0], [1.0], [4.0]])
        w = 9 * np.exp(-((z[:, 0] - 1) ** 2) / 8) / root
        np.testing.assert_allclose(at(z), 0.5 * z[:, 0] ** 2 + 0.25 * w**2 + 9 - w**2, rtol=1e-14)

    def test_predicts_with_type_prior(self):
        units = []
        for seed in range(1, 4):
            units.append(self.folder / f"unit-{seed}.db")
            gyrotherm("run", "tests/python/two_cycles.toml", "--rig", "profiles/rigs/virtual.toml", "--seed", seed,
                      "--out", units[-1], "--quiet")
        gyrotherm("type-prior", *units, "--out", self.folder / "prior.json")
        file = self.folder / "prior-model.json"
        gyrotherm("train", self.path, "--prior", self.folder / "prior.json", "--clusters", "0:40", "--out", file)
        self.assertEqual(module.load_model(file).method, "type-prior")
        self.agree(self.path, file)

    def test_refuses_files_that_are_not_models(self):
        for text, why in (("{", "expected a model file"), ("[]", "not a JSON object"),
                          ('{"schema": "x"}', 'schema "x"'), ('{"schema": "gyrotherm-model/1"}', "cannot|no model")):
            (self.folder / "bad.json").write_text(text)
            with self.assertRaisesRegex(module.ModelError, why):
                module.load_model(self.folder / "bad.json")

    def test_refuses_contradictory_models_like_program(self):
        file = self.folder / "whole-model.json"
        gyrotherm("train", self.path, "--method", "svr", "--quick", "--inputs", "A,A-B", "--out", file)
        whole = file.read_text()

        def changed(path, value):
            content = json.loads(whole)
            place = content
            for key in path[:-1]:
                place = place[key]
            place[path[-1]] = value
            return content

        for path, value in ((("terms", 0, "std"), -1), (("terms", 0, "std"), 0), (("target", "std_deg_per_h"), -1),
                            (("function", "beta"), [1.0]), (("function", "b"), float("nan")),
                            (("function", "support_vectors", 0), [1.0]), (("function", "parameters", "sigma"), 0)):
            file.write_text(json.dumps(changed(path, value)))
            with self.assertRaises(module.ModelError, msg=path):
                module.load_model(file)
            gyrotherm("verify", file, self.path, accept=(4,))

    def test_refuses_reversed_range(self):
        file = self.folder / "model.json"
        gyrotherm("train", self.path, "--method", "linear", "--inputs", "A,A-B", "--out", file)
        content = json.loads(file.read_text())
        content["terms"][1]["min"], content["terms"][1]["max"] = 50.0, -50.0
        file.write_text(json.dumps(content))
        with self.assertRaisesRegex(module.ModelError, "the max of an input is less than its min"):
            module.load_model(file)


class Folds(FolderTest):
    def test_folds_equal_those_of_program(self):
        """Least squares on these folds yields the program's held-out residual of each cluster."""
        path = record(self.folder / "run.db")
        run = module.open(path)
        for by in ("cycles", "blocks"):
            file = self.folder / f"{by}.json"
            gyrotherm("train", path, "--method", "linear", "--inputs", "A,A-B,A-C", "--folds", by, "--out", file)
            model, clusters = module.load_model(file), run.clusters()
            inputs = np.column_stack([np.ones(len(clusters)), clusters.inputs(model.terms)])
            left = np.full(len(clusters), np.nan)
            for training, held_out in run.folds(by):
                weights, *_ = np.linalg.lstsq(inputs[training], clusters.bias_deg_per_h[training], rcond=None)
                left[held_out] = clusters.bias_deg_per_h[held_out] - inputs[held_out] @ weights
            np.testing.assert_allclose(left, model.json["leave_cycle_out_residual_deg_per_h"], rtol=0, atol=1e-10)
            rmse = model.json["leave_cycle_out"]["rmse_deg_per_h"]
            self.assertAlmostEqual(module.figures(left).rmse, rmse, delta=1e-12)

    def test_folds_of_several_records(self):
        clusters = module.open(record(self.folder / "one.db")).clusters()
        by_records = module.folds([clusters, clusters, clusters], "records")
        self.assertEqual([len(held_out) for _, held_out in by_records], [96] * 3)
        self.assertEqual([len(training) for training, _ in by_records], [192] * 3)
        with self.assertRaisesRegex(module.RecordError, "a record of another"):
            module.folds([clusters, clusters], "programs")
        self.assertEqual(len(module.folds([clusters, clusters], "cycles")), 4)


if __name__ == "__main__":
    unittest.main()

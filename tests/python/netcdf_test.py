# SPDX-License-Identifier: Apache-2.0
"""NetCDF exports and SQL views have the content of the record, as read by netCDF4, h5py, xarray and plain sqlite3."""

import shutil
import sqlite3
import unittest

from program import FolderTest, gyrotherm, need, record

need("netCDF4", "h5py")
import h5py
import netCDF4
import numpy as np
import xarray

import gyrotherm as module


def exported(path, out, *words):
    gyrotherm("export", path, "--as", "netcdf", "--out", out, "--unverified", *words)
    return out


class Netcdf(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.path = record(cls.folder / "run.db")
        database = sqlite3.connect(cls.path)
        database.execute("DELETE FROM sample WHERE slot BETWEEN 1000 AND 1009")
        database.execute("INSERT INTO gap VALUES(1000, 1009, 'tested', 0)")
        database.execute("UPDATE sample SET C = NULL, pulses = NULL, interval_ns = NULL WHERE slot = 1500")
        database.execute("UPDATE channel SET offset_k = 0.25 WHERE name = 'A'")
        database.commit()
        database.close()
        cls.run_ = module.open(cls.path)
        cls.file = exported(cls.path, cls.folder / "run.nc")

    def test_has_every_value_of_the_record(self):
        known = self.run_.to_xarray()
        with netCDF4.Dataset(self.file) as found:
            self.assertEqual(len(found.dimensions["time"]), known.sizes["time_s"])
            compared = 0
            for name in known.data_vars:
                if name not in found.variables or known[name].dtype.kind not in "fi":
                    continue
                values = np.ma.filled(found[name][:].astype(float), np.nan)
                expected = known[name].values.astype(float)
                if known[name].dtype.kind == "i":
                    expected[expected == -1] = np.nan
                np.testing.assert_array_equal(values, expected, err_msg=name)
                compared += 1
            self.assertGreaterEqual(compared, 16)
            rate = known["bias_deg_per_h"] + self.run_.axes[0].earth_rate_deg_per_h
            np.testing.assert_allclose(np.ma.filled(found["rate_deg_per_h"][:], np.nan), rate, rtol=1e-12)

    def test_opens_in_xarray_with_times_units_and_gaps(self):
        known = self.run_.to_xarray()
        with xarray.open_dataset(self.file) as found:
            measured = ~np.isnat(known["utc"].values)
            np.testing.assert_array_equal(found["time"].values[measured], known["utc"].values[measured])
            self.assertTrue((np.diff(found["time"].values) > np.timedelta64(0)).all())
            self.assertIn("SIMULATED", found.attrs["source"])
            self.assertEqual(found["A"].attrs["units"], "degC")
            self.assertEqual(found["rate_deg_per_h"].attrs["units"], "degree/hour")
            flags = found[found["C"].attrs["ancillary_variables"]]
            words = flags.attrs["flag_meanings"].split()
            self.assertEqual(words[int(flags[1005])], "gap")
            self.assertEqual(words[int(flags[1500])], "missing")
            self.assertEqual(words[int(flags[1501])], "measured")
            self.assertTrue(np.isnan(found["C"][[1005, 1500]]).all())
            self.assertIn("latitude", found.coords)

    def test_each_variable_is_described(self):
        with netCDF4.Dataset(self.file) as found:
            self.assertEqual((found.Conventions, found.featureType), ("CF-1.10", "timeSeries"))
            self.assertRegex(found["time"].units, r"^seconds since 2026-01-01 00:00:00\.000000 UTC$")
            for variable in found.variables.values():
                self.assertTrue(variable.long_name)
                self.assertRegex(getattr(variable, "flag_meanings", "_"), r"^[A-Za-z0-9_.+@ -]+$", variable.name)
                self.assertEqual(len(getattr(variable, "flag_meanings", "").split()),
                                 len(np.atleast_1d(getattr(variable, "flag_values", []))), variable.name)
                if "flag" not in variable.name and variable.dtype.kind == "f":
                    self.assertTrue(variable.units)
                for name in getattr(variable, "ancillary_variables", "").split():
                    self.assertIn(name, found.variables)

    def test_states_unit_and_order(self):
        order, path = self.folder / "order.toml", self.folder / "lot.db"
        order.write_text('schema = "gyrotherm-order/1"\nnumber = "2026-17"\nserial_numbers = ["0042"]\n'
                         '[customer]\nname = "N"\n')
        gyrotherm("run", "tests/profiles/ten-seconds.toml", "--rig", "virtual", "--unit", "0042", "--order", order,
                  "--out", path, "--quiet")
        info = module.open(path).info
        self.assertEqual((info.order_number, info.units[0].serial_number, info.units[0].in_use), ("2026-17", "0042", True))
        self.assertEqual(self.run_.info.order_number, "")
        with netCDF4.Dataset(exported(path, self.folder / "lot.nc")) as found:
            self.assertEqual(found.order_number, "2026-17")
            self.assertEqual(found["rate_deg_per_h"].serial_number, "0042")
        with netCDF4.Dataset(self.file) as found:
            self.assertNotIn("order_number", found.ncattrs())

    def test_is_an_hdf5_file(self):
        with h5py.File(self.file) as found:
            self.assertEqual(found["A"].shape, found["time"].shape)
            self.assertIn(b"SIMULATED", np.bytes_(found.attrs["source"]))

    def test_exports_part_and_means(self):
        known = self.run_.to_xarray()
        part = exported(self.path, self.folder / "part.nc", "--from", "601 s", "--to", "660 s", "--every", "10 s")
        with xarray.open_dataset(part) as found:
            self.assertEqual(found.sizes["time"], 6)
            rows = known["B"].values[600:660].reshape(6, 10)
            np.testing.assert_allclose(found["B"], rows.mean(axis=1), rtol=1e-14)
            np.testing.assert_array_equal(found["pulses"], known["pulses"].values[600:660].reshape(6, 10).sum(axis=1))
            np.testing.assert_allclose(found["interval_s"], known["interval_s"].values[600:660].reshape(6, 10).sum(axis=1))
        by_clock = exported(self.path, self.folder / "clock.nc", "--from", "2026-01-01T00:10:01Z",
                            "--to", "2026-01-01T01:11:00+01:00", "--every", "10 s")
        with xarray.open_dataset(part) as one, xarray.open_dataset(by_clock) as other:
            xarray.testing.assert_identical(one, other)

    def test_mean_in_gap_is_missing(self):
        with xarray.open_dataset(exported(self.path, self.folder / "gap.nc", "--every", "5 s")) as found:
            self.assertTrue(np.isnan(found["A"][200:202]).all())
            self.assertFalse(np.isnan(found["A"][202]))
            self.assertTrue((np.diff(found["time"].values) == np.timedelta64(5, "s")).all())

    def test_means_in_gap_are_on_grid(self):
        path = self.folder / "cut.db"
        shutil.copy(self.path, path)
        with sqlite3.connect(path) as database:  # the group 1010 … 1014 begins in the gap; another gap follows
            database.execute("DELETE FROM sample WHERE slot BETWEEN 1010 AND 1012 OR slot BETWEEN 1015 AND 1024")
            database.execute("INSERT INTO gap VALUES(1010, 1012, 'tested', 0), (1015, 1024, 'tested', 0)")
        with netCDF4.Dataset(exported(path, self.folder / "cut.nc", "--every", "5 s")) as found:
            np.testing.assert_array_equal(found["time"][199:207] - found["time"][0], [995, 1000, 1005, 1013, 1015, 1020, 1025, 1030])

    def test_states_when_unit_was_turned(self):
        import pandas

        profile = self.folder / "turned.toml"
        turns = [("hold", ""), ("hold", 'axis = "turned"\n'), ("hold", 'axis = "as mounted"\n')]
        profile.write_text('schema = "gyrotherm-profile/1"\nname = "turned"\n' + "".join(
            f'[[segment]]\nkind = "{kind}"\nat = "20 °C"\ntime = "5 min"\n{axis}' for kind, axis in turns))
        path = record(self.folder / "turned.db", profile=profile)
        run = module.open(path)
        bias, earth_rate = run.to_pandas()["bias_deg_per_h"].values, run.axes[0].earth_rate_deg_per_h
        self.assertLess(np.nanmax(np.abs(bias)), 1)
        with netCDF4.Dataset(exported(path, self.folder / "turned.nc")) as found:
            turned = np.ma.filled(found["turned"][:].astype(float), np.nan)
            np.testing.assert_allclose(found["rate_deg_per_h"][:] - earth_rate * (1 - 2 * turned), bias, rtol=1e-9)
        gyrotherm("export", path, "--out", self.folder / "turned.csv")
        table = pandas.read_csv(self.folder / "turned.csv", comment="#")
        np.testing.assert_array_equal(table["turned"], turned)
        self.assertEqual(set(turned[~np.isnan(turned)]), {0, 1})
        self.assertNotIn("turned", netCDF4.Dataset(self.file).variables)

    def test_text_table_accepts_same_options(self):
        gyrotherm("export", self.path, "--out", self.folder / "part.csv", "--unverified", "--every", "1 min")
        import pandas

        table = pandas.read_csv(self.folder / "part.csv", comment="#")
        known = self.run_.to_xarray(calibrated=False)["A"].values
        np.testing.assert_allclose(table["A [°C]"][0], known[:60].mean(), rtol=1e-14)
        self.assertEqual(list(table["slot"][:3]), [0, 60, 120])


MAP = """schema = "gyrotherm-import/1"
name = "foreign"
[file]
format = "netcdf"
[time]
{time}
[[thermometer]]
name = "wall"
column = "{thermometer}"
[gyro]
column = "rate"
kind = "rate"
scale = 1
"""


class Import(FolderTest):
    """NetCDF of other programs, packed as CF allows."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.file = cls.folder / "foreign.nc"
        cls.rows = 40_000
        with netCDF4.Dataset(cls.file, "w") as made:
            made.createDimension("obs", cls.rows)
            time = made.createVariable("when", "f8", ("obs",))
            time.units = "minutes since 2026-03-01 13:00:00 +01:00"
            time[:] = np.arange(cls.rows) / 60
            packed = made.createVariable("T", "i2", ("obs",), fill_value=-32768)
            packed.scale_factor, packed.add_offset = 0.01, 20.0
            packed[:] = np.ma.masked_equal(20 + (np.arange(cls.rows) % 100) * 0.01, 20.07)
            made.createVariable("rate", "f4", ("obs",))[:] = np.arange(cls.rows) % 7

    def imported(self, **words):
        words = {"time": 'column = "when"', "thermometer": "T", **words}
        (self.folder / "map.toml").write_text(MAP.format(**words))
        path = self.folder / f"{len(self.files())}.db"
        gyrotherm("import", self.file, "--map", self.folder / "map.toml", "--out", path)
        return path

    def test_imports_values_and_utc(self):
        path = self.imported()
        run = module.open(path)
        self.assertEqual(repr(run), "<run of foreign.nc, 40000 rows over 39999 s, gyro>")
        frame = run.to_pandas()
        self.assertEqual(len(frame), self.rows)
        self.assertEqual(str(frame["utc"].iloc[0]), "2026-03-01 12:00:00+00:00")
        with netCDF4.Dataset(self.file) as made:
            np.testing.assert_allclose(frame["wall"], np.ma.filled(made["T"][:], np.nan), rtol=1e-14)
            np.testing.assert_array_equal(frame["pulses"], made["rate"][:])

    def test_joins_rows(self):
        path = self.imported(time='column = "when"\nevery = "100 s"')
        self.assertEqual(len(module.open(path).to_pandas()), self.rows // 100)

    def test_lists_variables_when_one_is_missing(self):
        with self.assertRaisesRegex(AssertionError, 'no column "t", expected one of: "T", "rate"'):
            self.imported(thermometer="t")

    def test_imports_own_export(self):
        path = record(self.folder / "run.db")
        exported(path, self.folder / "run.nc")
        (self.folder / "back.toml").write_text(MAP.format(time="", thermometer="A").replace('"rate"\nkind', '"rate_deg_per_h"\nkind'))
        gyrotherm("import", self.folder / "run.nc", "--map", self.folder / "back.toml", "--out", self.folder / "back.db")
        there, back = module.open(path).to_pandas(), module.open(self.folder / "back.db").to_pandas()
        np.testing.assert_array_equal(back["wall"], there["A"])
        np.testing.assert_array_equal(back["utc"], there["utc"])


class ForeignFiles(FolderTest):
    """Times and missing values in files of other programs."""

    def made(self, times, units, kind="f8", calendar="", temperatures=None, temperature_kind="f4", **attributes):
        """Returns the file, by default with a thermometer of zeros. A thermometer of None is not written."""
        path = self.folder / f"{len(self.files())}.nc"
        with netCDF4.Dataset(path, "w") as made:
            made.createDimension("time", len(times))
            time = made.createVariable("time", kind, ("time",))
            time.units = units
            if calendar:
                time.calendar = calendar
            time[:] = np.array(times, dtype=kind)
            rate = made.createVariable("rate", "f8", ("time",))
            rate[:] = np.arange(len(times))
            fill = attributes.pop("_FillValue", None)
            wall = made.createVariable("T", temperature_kind, ("time",), fill_value=fill)
            wall.set_auto_maskandscale(False)
            for name, value in attributes.items():
                wall.setncattr(name, value)
            for i, value in enumerate(temperatures or np.zeros(len(times))):
                if value is not None:
                    wall[i] = value
        return path

    def imported(self, file, time=""):
        (self.folder / "map.toml").write_text(MAP.format(time=time, thermometer="T"))
        path = self.folder / f"{len(self.files())}.db"
        gyrotherm("import", file, "--map", self.folder / "map.toml", "--out", path)
        return module.open(path).to_pandas()

    def utcs(self, *arguments, **words):
        return [str(utc) for utc in self.imported(self.made(*arguments, **words))["utc"]]

    def test_keeps_each_nanosecond_since_1970(self):
        first = 1767225600_000000000
        for kind in ("i8", "u8"):
            frame = self.imported(self.made([first, first + 1_000_000, first + 10_000_000, first + 20_000_100],
                                            "nanoseconds since 1970-01-01", kind=kind))
            np.testing.assert_array_equal(frame.index, [0, 0.001, 0.01, 0.0200001])
            self.assertEqual(str(frame["utc"].iloc[1]), "2026-01-01 00:00:00.001000+00:00")

    def test_keeps_seconds_since_1970(self):
        frame = self.imported(self.made(1767225600 + np.arange(1000) / 100, "seconds since 1970-01-01"))
        np.testing.assert_array_equal(frame.index, np.arange(1000) / 100)
        grouped = self.imported(self.made(1767225600 + np.arange(1000) / 100, "seconds since 1970-01-01"),
                                time='every = "100 ms"')
        np.testing.assert_array_equal(grouped["pulses"], np.arange(100) * 10 + 4.5)
        np.testing.assert_array_equal(self.imported(self.made([0.1, 0.2, 0.7], "s", kind="f4")).index, [0, 0.1, 0.6])

    def test_uses_epoch_of_file(self):
        noon = "2026-03-01 12:00:00+00:00"
        for hours, units in ((1105932, "hours since 1900-01-01 00:00:00.0"), (1105932, "hr since 1900-1-1"),
                             (12, "hours since 2026-3-1 0:0:0"), (6, "Hours since 2026-03-01 12:00:00 +6:00"),
                             (12 * 3600, "secs since 2026-03-01 00:00:00 GMT"), (720, "mins since 2026-03-01"),
                             (12 * 3600_000, "msec since 2026-03-01T00:00:00Z")):
            self.assertEqual(self.utcs([hours], units), [noon], units)

    def test_reads_days_before_calendar_reform_like_others(self):
        for calendar in ("standard", "gregorian", "proleptic_gregorian"):
            units = "days since 0001-01-01"
            expected = netCDF4.num2date(739000.25, units, calendar)
            self.assertEqual(self.utcs([739000.25], units, calendar=calendar), [f"{expected}+00:00"], calendar)

    def test_explains_invalid_units_of_time(self):
        for units, message in (("fortnights since 2026-03-01", '"fortnights" is not a unit of time'),
                               ("seconds since the start", '"the start" is not a time'),
                               ("seconds since 2026-02-30", '"2026-02-30" is not a time')):
            with self.assertRaisesRegex(AssertionError, message):
                self.imported(self.made([0], units))

    def test_ignores_fill_values(self):
        for kind in ("f4", "f8", "i2", "u2", "i4", "u4", "i8", "u8"):
            wall = self.imported(self.made(range(3), "s", temperatures=[20, None, 21], temperature_kind=kind))["wall"]
            np.testing.assert_array_equal(wall, [20, np.nan, 21], err_msg=kind)
        with netCDF4.Dataset(self.made(range(3), "s", temperatures=[20, -127, 21], temperature_kind="i1")) as bytes_:
            np.testing.assert_array_equal(self.imported(bytes_.filepath())["wall"], [20, -127, 21])

    def test_accepts_several_missing_values(self):
        wall = self.imported(self.made(range(5), "s", temperatures=[1, -999, -998, -5, -32768], temperature_kind="i2",
                                       _FillValue=np.int16(-32768), missing_value=np.array([-999, -998], "i2"),
                                       scale_factor=0.01, add_offset=20.0))["wall"]
        np.testing.assert_allclose(wall, [20.01, np.nan, np.nan, 19.95, np.nan], rtol=1e-14)

    def test_converts_missing_value_to_type_of_variable(self):
        for kind, missing in (("f4", np.float64(-999.9)), ("f4", np.int32(-999)), ("i2", np.float64(-999)),
                              ("f8", np.float32(-999.5)), ("i4", np.int16(-999))):
            with netCDF4.Dataset(self.made(range(3), "s", temperatures=[20, missing, 21], temperature_kind=kind,
                                           missing_value=missing)) as made:
                np.testing.assert_array_equal(self.imported(made.filepath())["wall"], [20, np.nan, 21],
                                              err_msg=f"{kind}, {missing.dtype}")

    def test_refuses_missing_value_that_is_not_a_number(self):
        with self.assertRaisesRegex(AssertionError, 'the attribute missing_value of "T" is not a number'):
            self.imported(self.made([0], "s", missing_value="-999"))

    def file_with_time_attributes(self, **attributes):
        """Returns a file whose time has the given attributes. A function is called with the variable and the name."""
        path = self.made([0], "s")
        with netCDF4.Dataset(path, "a") as made:
            for name, value in attributes.items():
                if callable(value):
                    value(made["time"], name)
                else:
                    made["time"].setncattr(name, value)
        return path

    def test_accepts_strings_as_text(self):
        def string(text):
            return lambda variable, name: variable.setncattr_string(name, text)

        units = "days since 2026-03-01 12:00:00"
        frame = self.imported(self.file_with_time_attributes(units=string(units), calendar=string("standard")))
        self.assertEqual(str(frame["utc"].iloc[0]), "2026-03-01 12:00:00+00:00")
        for calendar in ("noleap", string("noleap")):
            with self.assertRaisesRegex(AssertionError, 'has the calendar "noleap"'):
                self.imported(self.file_with_time_attributes(units=units, calendar=calendar))

    def test_refuses_units_and_calendar_that_are_not_text(self):
        for name, value in (("units", 1), ("calendar", np.array([1.0, 2.0])), ("calendar", ["standard", "noleap"])):
            with self.assertRaisesRegex(AssertionError, f'the attribute {name} of "time" is not a text'):
                self.imported(self.file_with_time_attributes(**{name: value}))

    def test_refuses_scale_that_is_not_a_number(self):
        for name, value in (("scale_factor", np.array([0.01, 0.02])), ("add_offset", "20")):
            with self.assertRaisesRegex(AssertionError, f'the attribute {name} of "T" is not a single number'):
                self.imported(self.made([0], "s", **{name: value}))


class Names(FolderTest):
    """Names that a record may contain, but NetCDF and CF do not permit."""

    def exported(self, header, rows, thermometers, time='column = "t"\nunit = "s"'):
        columns = "".join(f'[[thermometer]]\nname = "{name}"\ncolumn = "{column}"\n' for name, column in thermometers)
        (self.folder / "map.toml").write_text(
            'schema = "gyrotherm-import/1"\nname = "names"\n[file]\nmissing = [""]\n'
            f'[time]\n{time}\n{columns}[gyro]\ncolumn = "w"\nkind = "increment"\nscale = 1\n')
        (self.folder / "table.csv").write_text(header + "\n" + "\n".join(rows) + "\n")
        path = self.folder / f"{len(self.files())}.db"
        gyrotherm("import", self.folder / "table.csv", "--map", self.folder / "map.toml", "--out", path)
        return exported(path, self.folder / f"{len(self.files())}.nc")

    def test_names_auxiliary_variables_uniquely(self):
        for names in (("T 1", "T_1"), ("A_flag", "A"), ("A", "A_flag")):
            file = self.exported("t,T,U,w", ["0,1,10,5", "1,,11,6", "2,3,12,7"], zip(names, "TU"))
            with netCDF4.Dataset(file) as found:
                by_channel = {getattr(variable, "channel", name): variable
                              for name, variable in found.variables.items() if hasattr(variable, "calibration")}
                self.assertEqual(set(by_channel), set(names))
                for channel, missing in zip(names, (True, False)):
                    flags = found[by_channel[channel].ancillary_variables]
                    self.assertIn(f"reading of {channel}", flags.long_name)
                    self.assertEqual(list(flags[:]), [0, 1 if missing else 0, 0], channel)
                rate = found["rate_deg_per_h"]
                self.assertTrue(found[rate.ancillary_variables].long_name.startswith("pulses of"))

    def test_time_without_utc_has_no_standard_name(self):
        rows = ["0,20,1", "1,20,1"]
        with netCDF4.Dataset(self.exported("t,T,w", rows, [("A", "T")])) as found:
            self.assertEqual(found["time"].units, "s")
            self.assertFalse(hasattr(found["time"], "standard_name"))
        time = 'column = "t"\nunit = "s"\nsince = "2026-03-01T00:00:00Z"'
        with netCDF4.Dataset(self.exported("t,T,w", rows, [("A", "T")], time)) as found:
            self.assertEqual(found["time"].standard_name, "time")


class Views(FolderTest):
    def test_plain_sql_reads_same_values(self):
        path = record(self.folder / "run.db")
        frame = module.open(path).to_pandas()
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
            rows = database.execute("SELECT * FROM v1_sample")
            names = [column[0] for column in rows.description]
            table = dict(zip(names, zip(*rows.fetchall())))
            kinds = {kind for kind, in database.execute("SELECT kind FROM v1_event")}
            channels = dict(database.execute("SELECT name, unit FROM v1_channel"))
        for name in ("A", "shell", "chamber_air_c", "interval_s", "true_bias_deg_per_h"):
            np.testing.assert_array_equal(np.array(table[name], dtype=float), frame[name], err_msg=name)
        rate = frame["pulses"] * module.open(path).axes[0].scale / frame["interval_s"]
        np.testing.assert_allclose(table["rate_deg_per_h"], rate, rtol=1e-14)
        self.assertEqual(table["utc"][0], "2026-01-01T00:00:01.000Z")
        self.assertEqual(list(table["phase"]), list(frame["phase"]))
        self.assertIn("started", kinds)
        self.assertEqual((channels["A"], channels["rate_deg_per_h"]), ("°C", "°/h"))
        self.assertTrue(set(channels) <= set(names))


class Gnuplot(FolderTest):
    def test_breaks_lines_at_gaps(self):
        path = record(self.folder / "gap.db")
        with sqlite3.connect(path) as database:
            database.execute("DELETE FROM sample WHERE slot BETWEEN 1000 AND 1009")
            database.execute("INSERT INTO gap VALUES(1000, 1009, 'tested', 0)")
        for every, where in (((), ("1000", "1011")), (("--every", "5 s"), ("996", "1011"))):
            out = self.folder / f"{len(every)}.gp"
            gyrotherm("export", path, "--as", "gnuplot", "--out", out, "--unverified", *every)
            rows = out.read_text().split("$rows << end_of_rows\n")[1].split("end_of_rows\n")[0].split("\n")
            breaks = [i for i, row in enumerate(rows[:-1]) if not row]
            self.assertEqual([(rows[i - 1].split()[0], rows[i + 1].split()[0]) for i in breaks], [where])

    def test_script_contains_data_and_draws(self):
        path = record(self.folder / "run.db")
        gyrotherm("export", path, "--as", "gnuplot", "--every", "1 min", "--out", self.folder / "run.gp")
        script = (self.folder / "run.gp").read_text()
        self.assertIn("title 'SIMULATED: ", script)
        self.assertEqual(script.count("with lines"), 2 + 9 + 1)
        self.check_drawing("run")

    def test_draws_temperatures_of_silent_gyro(self):
        path = record(self.folder / "silent.db")
        with sqlite3.connect(path) as database:
            database.execute("UPDATE sample SET pulses = NULL, interval_ns = NULL")
        gyrotherm("export", path, "--as", "gnuplot", "--out", self.folder / "silent.gp", "--unverified")
        self.check_drawing("silent")

    def check_drawing(self, name):
        if not shutil.which("gnuplot"):
            return
        import subprocess

        drawn = subprocess.run(["gnuplot", "-e", f"set terminal svg; set output '{name}.svg'", f"{name}.gp"],
                               cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((drawn.returncode, drawn.stderr), (0, ""))
        self.assertIn("</svg>", (self.folder / f"{name}.svg").read_text())


if __name__ == "__main__":
    unittest.main()

// SPDX-License-Identifier: Apache-2.0
#include "report/document_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/json.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kNotice =
    R"js(/* dygraphs, (c) 2006-2017 Dan Vanderkam, (c) 2011-2023 Paul Felix, Robert Konigsberg,
David Eberlein, Google, Inc., mirabilos, Petr Shevtsov, Deutsche Telekom LLCTO and numerous contributors. Licence (MIT):
Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions: The above copyright notice and
this permission notice shall be included in all copies or substantial portions of the Software. THE SOFTWARE IS PROVIDED
"AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF
MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT
HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE,
ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
)js";

/// Script that draws a figure once it is near the visible area. Touches scroll the page and do not zoom.
constexpr const char* kScript = R"js(
(function () {
  'use strict';
  var language = document.documentElement.lang;
  function written(value) {
    return value.toLocaleString(language, {maximumSignificantDigits: 6, useGrouping: false}).replace('-', '\u2212');
  }
  function written_by(axis) {
    var fixed = {minimumFractionDigits: axis.decimals, maximumFractionDigits: axis.decimals, useGrouping: false};
    return function (value) {
      return value.toLocaleString(language, fixed).replace('-', '\u2212') + axis.unit;
    };
  }
  function as_text(text) {
    var box = document.createElement('span');
    box.textContent = text;
    return box.innerHTML;
  }
  function rows_of(lines) {
    var rows = new Map();
    lines.forEach(function (line, k) {
      line.x.forEach(function (x, i) {
        var row = rows.get(x);
        if (!row) rows.set(x, row = [x].concat(lines.map(function () { return null; })));
        row[k + 1] = line.y[i] === null ? NaN : line.y[i];
      });
    });
    return Array.from(rows.values()).sort(function (a, b) { return a[0] - b[0]; });
  }
  /* The width of a value is reserved while none is shown, so that the figure below does not move. */
  function value_box(text, axis) {
    var box = document.createElement('b');
    var write = written_by(axis);
    box.style.minWidth = Math.min(24, Math.max(write(axis.low).length, write(axis.high).length) + 1) + 'ch';
    box.textContent = text || '\u00a0';
    return box;
  }
  function legend_of(shown, data) {
    var box = document.createElement('div');
    box.append(value_box(shown.xHTML, data.x_axis));
    shown.series.forEach(function (one, k) {
      var entry = document.createElement('span'), line = document.createElement('i');
      line.style.borderTop = '3px ' + (data.lines[k].dashed ? 'dashed ' : 'solid ') + data.lines[k].colour;
      entry.append(line, ' ' + data.lines[k].name + ' ', value_box(one.yHTML, data.y_axis));
      box.append(entry);
    });
    return box.innerHTML;
  }
  function draw_mark(context, area, mark) {
    context.save();
    context.translate(area.x + area.w / 2, area.y + area.h / 2);
    context.rotate(-0.21);
    context.font = 'bold ' + Math.min(38, area.w / 8) + 'px sans-serif';
    context.textAlign = 'center';
    context.fillStyle = 'rgba(168, 55, 27, 0.12)';
    context.fillText(mark, 0, 0);
    context.restore();
  }
  function draw(figure) {
    var data = JSON.parse(figure.querySelector('script').textContent);
    var chart = figure.querySelector('.chart'), legend = figure.querySelector('.chart-legend');
    figure.classList.add('live');
    var touchless = Object.assign({}, Dygraph.defaultInteractionModel);
    delete touchless.touchstart;
    delete touchless.touchmove;
    delete touchless.touchend;
    var series = {};
    data.lines.forEach(function (line) { series[line.name] = {strokePattern: line.dashed ? [6, 3] : null}; });
    new Dygraph(chart, rows_of(data.lines), {
      labels: [data.x].concat(data.lines.map(function (line) { return line.name; })),
      colors: data.lines.map(function (line) { return line.colour; }),
      series: series, xlabel: as_text(data.x), ylabel: as_text(data.y),
      labelsDiv: legend, legend: 'always', connectSeparatedPoints: true,
      legendFormatter: function (shown) { return legend_of(shown, data); },
      underlayCallback: function (context, area) { if (data.mark) draw_mark(context, area, data.mark); },
      strokeWidth: 1.3, rightGap: 32, highlightCircleSize: 3.5, interactionModel: touchless,
      gridLineColor: '#e3e7ec', axisLineColor: '#8b95a1', axisLabelFontSize: 12, xLabelHeight: 15, yLabelWidth: 15,
      axes: {
        x: {axisLabelFormatter: written, valueFormatter: written_by(data.x_axis), pixelsPerLabel: 60},
        y: {axisLabelFormatter: written, valueFormatter: written_by(data.y_axis), axisLabelWidth: 58}
      }
    });
  }
  var figures = Array.from(document.querySelectorAll('figure.enlargeable'));
  if (!window.IntersectionObserver) return figures.forEach(draw);
  var watch = new IntersectionObserver(function (seen) {
    seen.forEach(function (one) {
      if (!one.isIntersecting) return;
      watch.unobserve(one.target);
      draw(one.target);
    });
  }, {rootMargin: '300px'});
  figures.forEach(function (figure) { watch.observe(figure); });
})();
)js";

std::string numbers(const std::vector<double>& values, int digits) {
  std::string text = "[";
  for (const double value : values) {
    if (text.size() > 1) text += ',';
    text += std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "null";
  }
  return text + "]";
}

/// Returns a JSON string without '<'.
std::string quote_json(const std::string& text) {
  std::string json = json_text(Json(text)), safe;
  for (const char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

/// Describes an axis for the values of the legend: their unit, their range, and decimals for a thousandth of the range.
std::string axis_json(const FigureData& figure, std::vector<double> FigureLine::*values, const std::string& unit) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const FigureLine& line : figure.lines)
    for (const double value : line.*values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (!(low <= high)) low = high = 0;
  constexpr int kDigitsOfRange = 3, kMostDecimals = 12;
  const double range = high > low ? high - low : std::max(1.0, std::abs(high));
  const int decimals =
      std::isfinite(range) ? kDigitsOfRange - static_cast<int>(std::floor(std::log10(range))) : kDigitsOfRange;
  return fmt::format("{{\"unit\":{},\"decimals\":{},\"low\":{:.6g},\"high\":{:.6g}}}",
                     quote_json(append_unit("", unit)), std::clamp(decimals, 0, kMostDecimals), low, high);
}

/// Returns the name of a line with a number if necessary: dygraphs requires unique names.
std::string unique_name(Language language, const FigureData& figure, std::size_t index) {
  std::string name = line_name(language, figure, index);
  for (std::size_t k = 0; k < index; ++k)
    if (line_name(language, figure, k) == name) return fmt::format("{} ({})", name, index + 1);
  return name;
}

}  // namespace

bool can_be_enlarged(const FigureData& figure) {
  return !figure.logarithmic && std::ranges::all_of(figure.lines, [](const FigureLine& line) {
    return std::ranges::is_sorted(line.x) && std::ranges::all_of(line.x, [](double x) { return std::isfinite(x); });
  });
}

std::string chart_data(const FigureData& figure, Language language, std::size_t most_points, const std::string& mark) {
  constexpr int kDigitsOfX = 8, kDigitsOfY = 6;
  std::string lines;
  for (std::size_t k = 0; k < figure.lines.size(); ++k) {
    const FigureLine& line = figure.lines[k];
    const plot::Points kept = plot::decimate(line.x, line.y, std::max<std::size_t>(1, most_points / 2));
    lines += fmt::format("{}{{\"name\":{},\"colour\":\"{}\",\"dashed\":{},\"x\":{},\"y\":{}}}",
                         lines.empty() ? "" : ",", quote_json(unique_name(language, figure, k)), line_colour(figure, k),
                         is_line_dashed(figure, k), numbers(kept.x, kDigitsOfX), numbers(kept.y, kDigitsOfY));
  }
  return fmt::format("{{\"x\":{},\"y\":{},\"x_axis\":{},\"y_axis\":{},\"mark\":{},\"lines\":[{}]}}",
                     quote_json(name_with_unit(translate(language, figure.x_key), figure.x_unit)),
                     quote_json(name_with_unit(translate(language, figure.y_key), figure.y_unit)),
                     axis_json(figure, &FigureLine::x, figure.x_unit), axis_json(figure, &FigureLine::y, figure.y_unit),
                     quote_json(mark), lines);
}

std::string chart_script() { return kNotice + std::string(dygraphs_script()) + kScript; }

}  // namespace gyrotherm::report

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "mapping/base/quantile.h"

namespace waymark::bench {
namespace {

/// The slope of a line through the logarithms; NaN for fewer than two of different abscissas.
double FitExponent(const std::vector<std::pair<double, double>>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [abscissa, ordinate] : points) {
    if (!(abscissa > 0 && ordinate > 0)) continue;
    const double log_x = std::log(abscissa), log_y = std::log(ordinate);
    n += 1, x += log_x, y += log_y, xx += log_x * log_x, xy += log_x * log_y;
  }
  const double spread = n * xx - x * x;
  return spread > 1e-9 ? (n * xy - x * y) / spread : NAN;
}

std::map<std::string, std::vector<Row>> ByLayout(const std::vector<Row>& rows) {
  std::map<std::string, std::vector<Row>> layouts;
  for (const Row& row : rows) layouts[row.layout].push_back(row);
  return layouts;
}

}  // namespace

namespace {

/// Which part of the frames that were due came, by the server's clock: one to everybody in every
/// period between the first and the last that anybody heard of, those two apart.
double ShareOfFrames(const std::vector<Heard>& heard, double frame_hz) {
  std::vector<double> sent_s;
  for (const Heard& phone : heard) {
    for (const ServerTime sent : phone.sent) sent_s.push_back(Seconds(sent.time_since_epoch()));
  }
  if (sent_s.empty()) return NAN;
  const auto [first, last] = std::ranges::minmax(sent_s);
  // Between two ticks, lest the jitter of one decides whether its frames count.
  const double begin_s = first + (1 + 0.5 / session::kTicksPerFrame) / frame_hz;
  const double due = std::floor((last - begin_s) * frame_hz - 1);
  const double end_s = begin_s + due / frame_hz;
  const auto came = std::ranges::count_if(
      sent_s, [&](double time_s) { return begin_s <= time_s && time_s < end_s; });
  return due < 1 ? NAN : static_cast<double>(came) / static_cast<double>(heard.size()) / due;
}

}  // namespace

void Summarise(const Walked& walked, double frame_hz, Row& row) {
  std::vector<float> ages_ms, legs_ms;
  double bytes = 0, poses = 0;
  for (const Heard& phone : walked.heard) {
    bytes += static_cast<double>(phone.bytes);
    poses += static_cast<double>(phone.poses);
    ages_ms.insert(ages_ms.end(), phone.ages_ms.begin(), phone.ages_ms.end());
    legs_ms.insert(legs_ms.end(), phone.legs_ms.begin(), phone.legs_ms.end());
  }
  const auto count = static_cast<double>(walked.heard.size());
  row.delivered = ShareOfFrames(walked.heard, frame_hz);
  row.bytes_per_s = bytes / count / walked.seconds;
  row.poses_per_s = poses / count / walked.seconds;
  row.age_p50_ms = Quantile(ages_ms, 0.5, NAN);
  row.age_p99_ms = Quantile(ages_ms, 0.99, NAN);
  row.leg_p50_ms = Quantile(legs_ms, 0.5, NAN);
  row.leg_p99_ms = Quantile(legs_ms, 0.99, NAN);
}

void PrintHead() {
  fmt::print(
      "{:<8} {:>6} {:>6} {:>9} {:>12} {:>12} {:>7} {:>7} {:>20} {:>13}\n"
      "{:<8} {:>6} {:>6} {:>9} {:>12} {:>12} {:>7} {:>7} {:>20} {:>13}\n",
      "layout", "phones", "join", "frames", "report>heard", "tick>heard", "poses", "kB/s", "cores",
      "MiB", "", "", "s", "of due %", "p50/p99 ms", "p50/p99 ms", "/s", "a phone",
      "server gatew. phones", "server gatew.");
}

void Print(const Row& row) {
  fmt::print(
      "{:<8} {:>6} {:>6.2f} {:>9.3f} {:>6.1f}{:>6.0f} {:>6.2f}{:>6.1f} {:>7.0f} {:>7.1f} "
      "{:>6.3f} {:>6.3f} {:>6.3f} {:>6.0f} {:>6.0f}\n",
      row.layout, row.phones, row.join_s, 100 * row.delivered, row.age_p50_ms, row.age_p99_ms,
      row.leg_p50_ms, row.leg_p99_ms, row.poses_per_s, row.bytes_per_s / 1e3, row.server_cores,
      row.gateway_cores, row.generator_cores, row.server_mib, row.gateway_mib);
  std::fflush(stdout);
}

void PrintGrowth(const std::vector<Row>& rows) {
  for (const auto& [layout, of_layout] : ByLayout(rows)) {
    if (of_layout.size() < 2) continue;  // no growth in one
    const auto fit = [&](double Row::*figure) {
      std::vector<std::pair<double, double>> points;
      for (const Row& row : of_layout) points.emplace_back(row.phones, row.*figure);
      return FitExponent(points);
    };
    fmt::print(
        "{}: grows with the phones to the power of {:.2f} (latency), {:.2f} (bytes to a phone), "
        "{:.2f} (server's time), {:.2f} (gateway's time)\n",
        layout, fit(&Row::age_p50_ms), fit(&Row::bytes_per_s), fit(&Row::server_cores),
        fit(&Row::gateway_cores));
  }
}

bool WriteCsv(const std::vector<Row>& rows, const std::string& path) {
  std::ofstream file(path);
  file << "layout,phones,join_s,delivered,age_p50_ms,age_p99_ms,leg_p50_ms,leg_p99_ms,poses_per_s,"
          "bytes_per_s,server_cores,gateway_cores,generator_cores,server_mib,gateway_mib\n";
  for (const Row& row : rows) {
    file << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", row.layout, row.phones,
                        row.join_s, row.delivered, row.age_p50_ms, row.age_p99_ms, row.leg_p50_ms,
                        row.leg_p99_ms, row.poses_per_s, row.bytes_per_s, row.server_cores,
                        row.gateway_cores, row.generator_cores, row.server_mib, row.gateway_mib);
  }
  return file.good();
}

// ---- the plot ---------------------------------------------------------------------------------

namespace {

/// One diagram: phones to the right on a logarithmic scale, a figure upward from zero.
class Diagram {
 public:
  Diagram(double left, const std::string& title, double top_value, double max_phones)
      : left_(left), top_value_(top_value), max_log_(std::log10(max_phones)) {
    svg_ += fmt::format("<text x=\"{}\" y=\"24\" font-weight=\"bold\">{}</text>\n", left_, title);
    for (int i = 0; i <= 4; ++i) {
      const double value = top_value_ * i / 4;
      svg_ += fmt::format(
          "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#ddd\"/>"
          "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
          left_, left_ + kWidth, Y(value), left_ - 6, Y(value) + 4, value);
    }
    for (const double phones : {10.0, 30.0, 100.0, 300.0, 1000.0}) {
      if (phones > max_phones * 1.01) continue;
      svg_ += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                          X(phones), kTop + kHeight + 18, phones);
    }
    svg_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">phones</text>\n",
                        left_ + kWidth / 2, kTop + kHeight + 36);
  }

  void AddLine(const std::vector<Row>& rows, double Row::*figure, double unit,
               const std::string& colour, const std::string& name) {
    std::string points;
    for (const Row& row : rows) {
      const double x = X(row.phones), y = Y(row.*figure / unit);
      points += fmt::format("{:.1f},{:.1f} ", x, y);
      svg_ +=
          fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x, y, colour);
    }
    svg_ += fmt::format(
        "<polyline points=\"{0}\" fill=\"none\" stroke=\"{1}\" stroke-width=\"1.5\"/>"
        "<text x=\"{2}\" y=\"{3}\" fill=\"{1}\">{4}</text>\n",
        points, colour, left_ + 10, kTop + 14 + 16 * lines_++, name);
  }

  const std::string& svg() const { return svg_; }

 private:
  static constexpr double kTop = 40, kWidth = 300, kHeight = 220;

  double X(double phones) const {
    return left_ + kWidth * (std::log10(phones) - 0.9) / (max_log_ - 0.9 + 0.05);
  }
  double Y(double value) const {
    return kTop + kHeight * (1 - std::clamp(value / top_value_, 0.0, 1.05));
  }

  double left_, top_value_, max_log_;
  int lines_ = 0;
  std::string svg_;
};

double RoundUp(double value) {
  const double decade = std::pow(10, std::floor(std::log10(std::max(value, 1e-6))));
  for (const double step : {1.0, 2.0, 4.0, 6.0, 8.0, 10.0}) {
    if (value <= step * decade) return step * decade;
  }
  return 10 * decade;
}

double Largest(const std::vector<Row>& rows, double Row::*figure) {
  double largest = 0;
  for (const Row& row : rows) largest = std::max(largest, row.*figure);
  return largest;
}

}  // namespace

bool WritePlot(const std::vector<Row>& rows, const std::string& path) {
  double max_phones = 10;
  for (const Row& row : rows) max_phones = std::max(max_phones, 1.0 * row.phones);
  Diagram latency(60, "report to hearing it, ms", RoundUp(Largest(rows, &Row::age_p99_ms)),
                  max_phones);
  Diagram bytes(440, "kB/s to a phone", RoundUp(Largest(rows, &Row::bytes_per_s) / 1e3),
                max_phones);
  const std::vector<std::pair<std::string, std::string>> colours{
      {"#1f5fa8", "#8fb4dc"}, {"#c0561a", "#e8b08c"}, {"#2d7d46", "#97cfa8"}};
  std::size_t next = 0;
  for (const auto& [layout, of_layout] : ByLayout(rows)) {
    const auto& [dark, light] = colours[next++ % colours.size()];
    latency.AddLine(of_layout, &Row::age_p99_ms, 1, light, layout + " p99");
    latency.AddLine(of_layout, &Row::age_p50_ms, 1, dark, layout + " p50");
    bytes.AddLine(of_layout, &Row::bytes_per_s, 1e3, dark, layout);
  }
  std::ofstream file(path);
  file << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"780\" height=\"310\" "
          "font-family=\"sans-serif\" font-size=\"12\">\n"
          "<rect width=\"780\" height=\"310\" fill=\"white\"/>\n"
       << latency.svg() << bytes.svg() << "</svg>\n";
  return file.good();
}

}  // namespace waymark::bench

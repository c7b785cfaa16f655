// SPDX-License-Identifier: LGPL-2.1-or-later
#include "results/report.hpp"

#include "scenes/scenes.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <json-glib/json-glib.h>
#include <sstream>
#include <stdexcept>

namespace lab {
namespace {

namespace fs = std::filesystem;

class File {
public:
  explicit File(const fs::path &path) : path_(path), stream_(path) {}
  ~File() noexcept(false) {
    stream_.flush();
    if (!stream_ && std::uncaught_exceptions() == 0)
      throw std::runtime_error("'" + path_.string() + "' cannot be written");
  }
  File(const File &) = delete;
  File &operator=(const File &) = delete;

  // A row of comma-separated values. No text holds a comma or a quote: gnuplot takes neither.
  template <typename... Values>
  void row(const Values &...values) {
    const char *separator = "";
    ((stream_ << separator, put(values), separator = ","), ...);
    stream_ << '\n';
  }
  std::ostream &text() { return stream_; }

private:
  void put(const std::string &value) { stream_ << '"' << value << '"'; }
  void put(const char *value) { stream_ << value; }
  template <typename Number>
  void put(Number value) {
    stream_ << value;
  }

  fs::path path_;
  std::ofstream stream_;
};

void write_tables(const Report &report, const fs::path &folder) {
  const auto table = [&](const char *name, const char *columns, const auto &rows,
                         const auto &write) {
    File file(folder / name);
    file.row(columns);
    for (const auto &row : rows)
      write(file, row);
  };
  table("sweep.csv",
        "stratum,method,parameters,peer,default,threads,cases,error,error_low,error_high,error_p50,"
        "error_p95,gross,us_p50,us_p99,front",
        report.sweep, [](File &file, const SweepRow &r) {
          file.row(r.stratum, r.method, r.parameters, r.is_peer, r.is_default, r.threads, r.cases,
                   r.error, r.error_95.low, r.error_95.high, r.median, r.p95, r.gross, r.time,
                   r.time_99, r.on_front);
        });
  table("series.csv", "series,method,x,error,bias,gross,us_p50", report.series,
        [](File &file, const SeriesRow &r) {
          file.row(r.series, r.method, r.x, r.error, r.bias, r.gross, r.time);
        });
  table("streams.csv", "scene,us_p50,us_p99", report.streams,
        [](File &file, const StreamRow &r) { file.row(r.scene, r.time, r.time_99); });
  table("reliability.csv", "method,confidence,cases,good,good_low,good_high", report.reliability,
        [](File &file, const ReliabilityRow &r) {
          file.row(r.method, r.confidence, r.cases, r.good, r.good_95.low, r.good_95.high);
        });
  table("roc.csv", "method,threshold,false_alarms,detections", report.roc,
        [](File &file, const RocRow &r) {
          file.row(r.method, r.point.threshold, r.point.false_alarms, r.point.detections);
        });
  table("scenes.csv", "scene,method,error,bound", report.scenes,
        [](File &file, const SceneRow &r) { file.row(r.scene, r.method, r.error, r.bound); });
  table("clips.csv",
        "clip,method,cases,answered,shift_error_p50,shift_error_p95,reversal_error_p50",
        report.clips, [](File &file, const ClipRow &r) {
          file.row(r.clip, r.method, r.cases, r.answered, r.shift_error, r.shift_95,
                   r.reversal_error);
        });
  table("vectors.csv", "video,method,cases,answered,error,error_p95,us_decoding,us_region",
        report.vectors, [](File &file, const VectorRow &r) {
          file.row(r.video, r.method, r.cases, r.answered, r.error, r.p95, r.decoding, r.time);
        });
  table("fields.csv", "pair,method,cells,error,answered,error_answered,error_answered_p95,ms",
        report.fields, [](File &file, const FieldRow &r) {
          file.row(r.pair, r.method, r.cells, r.error, r.answered, r.error_answered, r.p95_answered,
                   r.time);
        });
}

// JSON

class Json {
public:
  Json() : builder_(json_builder_new()) {}
  ~Json() { g_object_unref(builder_); }
  Json(const Json &) = delete;
  Json &operator=(const Json &) = delete;

  template <typename Members>
  void object(const Members &members) {
    json_builder_begin_object(builder_);
    members();
    json_builder_end_object(builder_);
  }
  template <typename Elements>
  void array(const char *name, const Elements &elements) {
    json_builder_set_member_name(builder_, name);
    json_builder_begin_array(builder_);
    elements();
    json_builder_end_array(builder_);
  }
  void member(const char *name, const std::string &value) {
    json_builder_set_member_name(builder_, name);
    json_builder_add_string_value(builder_, value.c_str());
  }
  void member(const char *name, double value) {
    json_builder_set_member_name(builder_, name);
    json_builder_add_double_value(builder_, std::isfinite(value) ? value : 0);
  }
  void member(const char *name, bool value) {
    json_builder_set_member_name(builder_, name);
    json_builder_add_boolean_value(builder_, value);
  }
  void save(const fs::path &path) {
    JsonGenerator *generator = json_generator_new();
    JsonNode *root = json_builder_get_root(builder_);
    json_generator_set_root(generator, root);
    json_generator_set_pretty(generator, TRUE);
    json_generator_set_indent(generator, 1);
    GError *error = nullptr;
    json_generator_to_file(generator, path.c_str(), &error);
    json_node_unref(root);
    g_object_unref(generator);
    if (error) {
      const std::string text = error->message;
      g_error_free(error);
      throw std::runtime_error("'" + path.string() + "' cannot be written: " + text);
    }
  }

private:
  JsonBuilder *builder_;
};

void write_json(const Report &report, const fs::path &path) {
  Json json;
  json.object([&] {
    for (const auto &[name, value] : report.circumstances)
      json.member(name.c_str(), value);
    json.array("area-under-roc", [&] {
      for (const auto &row : report.area)
        json.object([&] {
          json.member("method", row.first);
          json.member("area", mean(row.second));
          json.member("worst", std::ranges::min(row.second));
        });
    });
    json.array("sweep", [&] {
      for (const SweepRow &r : report.sweep) {
        if (!r.is_default && !r.on_front)
          continue; // sweep.csv has all
        json.object([&] {
          json.member("stratum", r.stratum);
          json.member("method", r.method);
          json.member("parameters", r.parameters);
          json.member("default", r.is_default);
          json.member("threads", static_cast<double>(r.threads));
          json.member("error", r.error);
          json.member("error-low", r.error_95.low);
          json.member("error-high", r.error_95.high);
          json.member("us-p50", r.time);
          json.member("us-p99", r.time_99);
          json.member("front", r.on_front);
        });
      }
    });
  });
  json.save(path);
}

// The page

std::string rounded(double value) {
  std::ostringstream text;
  if (value != 0 && std::abs(value) < 10) {
    text.precision(value < 0.1 ? 1 : 2);
    if (std::abs(value) < 0.01)
      text << std::fixed, text.precision(4);
    else if (std::abs(value) < 1)
      text << std::fixed, text.precision(3);
  } else {
    text << std::fixed;
    text.precision(0);
  }
  text << value;
  return text.str();
}

std::string percent(double share) {
  return rounded(100 * share) + "%";
}

std::string rounded_or_dash(double value, bool is_known) {
  return is_known ? rounded(value) : "–";
}

std::string text(double value) {
  return rounded(value);
}
std::string text(std::size_t count) {
  return std::to_string(count);
}
const std::string &text(const std::string &words) {
  return words;
}

template <typename... Cells>
void write_line(std::ostream &out, const Cells &...cells) {
  ((out << '|' << text(cells)), ...);
  out << "|\n";
}

void write_head(std::ostream &out, std::initializer_list<const char *> names) {
  for (const char *name : names)
    out << '|' << name;
  out << "|\n";
  for (std::size_t i = 0; i < names.size(); ++i)
    out << "|---";
  out << "|\n";
}

// The texts of all rows with a separator between them.
template <typename Rows, typename Text>
std::string joined(const Rows &rows, const char *separator, const Text &text_of) {
  std::string all;
  for (const auto &row : rows)
    all += (all.empty() ? "" : separator) + text_of(row);
  return all;
}

// For the first cell of a row, and for a column. A name of a file keeps its case.
std::string capitalised(std::string words) {
  if (words.find('_') == std::string::npos)
    words[0] = g_ascii_toupper(words[0]);
  return words;
}

std::string title_of(const std::string &method) {
  if (method == "fast")
    return "**`method=fast`**";
  return method.starts_with("method=") ? "`" + method + "`" : capitalised(method);
}

bool is_ours(const SweepRow &row) {
  return row.method == "fast" && row.is_default && row.threads == 1;
}

std::vector<std::string> strata_of(const std::vector<SweepRow> &sweep) {
  std::vector<std::string> names;
  for (const SweepRow &row : sweep)
    if (std::ranges::find(names, row.stratum) == names.end())
      names.push_back(row.stratum);
  return names;
}

std::string name_of(const SweepRow &row) {
  return row.parameters.empty() ? row.method : row.method + ", " + row.parameters;
}

void write_strata(const Report &report, std::ostream &out) {
  write_head(out, {"stratum", "who", "mean error (px)", "95 % interval", "errors > 0.5 px",
                   "p50 (µs)", "p99 (µs)"});
  const auto line = [&](const char *role, const SweepRow &r) {
    write_line(out, r.stratum, role + name_of(r), r.error,
               rounded(r.error_95.low) + "–" + rounded(r.error_95.high), percent(r.gross), r.time,
               r.time_99);
  };
  for (const std::string &stratum : strata_of(report.sweep)) {
    const SweepRow *best_peer = nullptr;
    const SweepRow *best_own = nullptr;
    for (const SweepRow &row : report.sweep) {
      if (row.stratum != stratum || row.threads != 1)
        continue;
      if (is_ours(row))
        line("**as shipped**: ", row);
      const SweepRow *&best = row.is_peer ? best_peer : best_own;
      if (!best || row.error < best->error)
        best = &row;
    }
    if (best_own)
      line("most accurate of ours: ", *best_own);
    if (best_peer)
      line("most accurate peer: ", *best_peer);
  }
}

// The row of a method as its authors ship it, or nothing.
const SweepRow *shipped(const Report &report, const std::string &stratum, const std::string &method,
                        bool one_thread) {
  const auto found = std::ranges::find_if(report.sweep, [&](const SweepRow &r) {
    return r.stratum == stratum && r.method == method && r.is_default &&
           (r.threads == 1) == one_thread;
  });
  return found != report.sweep.end() ? &*found : nullptr;
}

void write_shipped(const Report &report, std::ostream &out) {
  write_head(out, {"method as shipped", "translation: error (px)", "pairs: error (px)", "p50 (µs)",
                   "times that of `method=fast`", "all threads (µs)"});
  const SweepRow *own = shipped(report, "translation", "fast", true);
  for (const SweepRow &row : report.sweep) {
    if (row.stratum != "translation" || !row.is_default || row.threads != 1)
      continue;
    const SweepRow *pairs = shipped(report, "pairs", row.method, true);
    const SweepRow *threaded = shipped(report, "translation", row.method, false);
    const bool has_own = own && own->time > 0;
    write_line(out, title_of(row.method), row.error,
               rounded_or_dash(pairs ? pairs->error : 0, pairs), row.time,
               rounded_or_dash(has_own ? row.time / own->time : 0, has_own),
               rounded_or_dash(threaded ? threaded->time : 0, threaded));
  }
}

void write_confidence(const Report &report, std::ostream &out) {
  if (report.area.empty())
    return;
  out << "The table has the area under the ROC curve for errors above 0.3 px. Every hard scene but "
      << kRoundedMotion << " was rendered with " << report.area.begin()->second.size()
      << " seeds.\n\n";
  write_head(out, {"method", "worst seed", "mean"});
  for (const auto &[method, areas] : report.area)
    write_line(out, title_of(method), std::ranges::min(areas), mean(areas));
  out << "\nThe confidence of `method=fast` and the share of good answers, with its 95 % "
         "interval:\n\n";
  write_head(out, {"confidence", "answers", "good (at most 0.3 px)"});
  constexpr double kHalf = 5; // per cent, of a bin
  for (const ReliabilityRow &r : report.reliability)
    if (r.method == "fast")
      write_line(out,
                 "From " + std::to_string(std::lround(100 * r.confidence - kHalf)) + " to " +
                     std::to_string(std::lround(100 * r.confidence + kHalf)) + "%",
                 r.cases,
                 percent(r.good) + " (" + rounded(100 * r.good_95.low) + "–" +
                     rounded(100 * r.good_95.high) + ")");
}

// The peer whose worst area under the ROC curve exceeds the default's most, or nothing.
void write_ahead_in_confidence(const Report &report, std::ostream &out) {
  const auto own = report.area.find("fast");
  if (own == report.area.end())
    return;
  const auto worst = [](const auto &row) { return std::ranges::min(row.second); };
  const auto best = std::ranges::max_element(report.area, {}, worst);
  if (worst(*best) > worst(*own))
    out << "* confidence: " << best->first << ", worst area under the ROC curve "
        << rounded(worst(*best)) << ", that of method=fast " << rounded(worst(*own)) << "\n";
}

// Strata in which the most accurate configuration of a peer has a smaller error than the default,
// with 95 % intervals that do not overlap.
void write_ahead(const Report &report, std::ostream &out) {
  bool any = false;
  for (const std::string &stratum : strata_of(report.sweep)) {
    const auto own = std::ranges::find_if(
        report.sweep, [&](const SweepRow &r) { return r.stratum == stratum && is_ours(r); });
    const SweepRow *best = nullptr;
    for (const SweepRow &row : report.sweep)
      if (row.stratum == stratum && row.is_peer && row.threads == 1 &&
          row.error_95.high < own->error_95.low && (!best || row.error < best->error))
        best = &row;
    if (!best)
      continue;
    any = true;
    out << "* " << stratum << ": " << name_of(*best) << ", " << rounded(best->error) << " px in "
        << rounded(best->time) << " µs\n";
  }
  out << (any ? "" : "In error, in no stratum of this run.\n");
  write_ahead_in_confidence(report, out);
  out << "\nSee also [scenes where a peer is ahead](#scenes-where-a-peer-is-ahead).\n";
}

// The peer with the smallest error in the scene of `own`, or nothing.
const SceneRow *best_peer(const Report &report, const SceneRow &own) {
  const SceneRow *best = nullptr;
  for (const SceneRow &row : report.scenes)
    if (row.scene == own.scene && row.method != "fast" && row.method != "method=opencv" &&
        row.method != "always zero" && (!best || row.error < best->error))
      best = &row;
  return best;
}

void write_scenes(const Report &report, std::ostream &out) {
  constexpr double kNegligible = 0.01; // px
  write_head(out, {"scene", "bound", "`method=fast`", "`method=opencv`", "best peer"});
  for (const SceneRow &own : report.scenes) {
    if (own.method != "fast")
      continue;
    const auto reference = std::ranges::find_if(report.scenes, [&](const SceneRow &r) {
      return r.scene == own.scene && r.method == "method=opencv";
    });
    const SceneRow *best = best_peer(report, own);
    if (!best || best->error + kNegligible >= own.error)
      continue;
    const bool has_reference = reference != report.scenes.end();
    write_line(out, capitalised(own.scene), rounded_or_dash(own.bound, own.bound < 1), own.error,
               rounded_or_dash(has_reference ? reference->error : 0, has_reference),
               rounded(best->error) + " " + best->method);
  }
}

void write_clips(const Report &report, std::ostream &out) {
  write_head(out, {"method", "clip", "regions", "answered", "shift: median (px)", "p95 (px)",
                   "reversal: median (px)"});
  for (const ClipRow &r : report.clips)
    if (r.method == "fast" || r.method == "method=opencv" || r.method == "PyrLK crop")
      write_line(out, title_of(r.method), r.clip, r.cases, percent(r.answered), r.shift_error,
                 r.shift_95, r.reversal_error);
}

void write_fields(const Report &report, std::ostream &out) {
  out << "The field has 32 columns. One thread computes it, from the luma of both frames to "
         "the cells. Dense flow is averaged over the same cells. A cell is sure if the field's "
         "confidence is 0.5 or more. A field without an answer counts as no motion.\n\n";
  write_head(out, {"pair", "method", "error (px)", "sure", "error there (px)", "p95 there (px)",
                   "time (ms)"});
  for (const FieldRow &r : report.fields)
    write_line(out, r.pair, r.method, r.error, percent(r.answered), r.error_answered,
               r.p95_answered, r.time);
}

// A row for each video, and a column for each method. The first row of a video has `about`.
template <typename About, typename Cell>
void write_by_method(const std::vector<VectorRow> &rows, const char *about_head, std::ostream &out,
                     const About &about, const Cell &cell) {
  const std::size_t methods =
      static_cast<std::size_t>(std::ranges::count(rows, rows.front().video, &VectorRow::video));
  out << "|video|" << about_head;
  std::string rule = "|---|---";
  for (std::size_t i = 0; i < methods; ++i) {
    out << '|' << title_of(rows[i].method);
    rule += "|---";
  }
  out << "|\n" << rule;
  std::string video;
  for (const VectorRow &row : rows) {
    if (row.video != video)
      out << "|\n|" << capitalised(row.video) << '|' << about(row);
    video = row.video;
    out << '|' << cell(row);
  }
  out << "|\n";
}

void write_vectors(const Report &report, std::ostream &out) {
  out << "*Vectors of the decoder* is the mean of its motion vectors (libavcodec) over the region. "
         "In a "
         "scene (352×288, one reference frame unless the row says otherwise) the error is measured "
         "against the true motion. In a clip it is measured against DIS medium with "
         "finest-scale=0.\n\nThe mean error in px, and in parentheses the error that 95 % of the "
         "regions stay below. The share of answers follows where some regions have none.\n\n";
  write_by_method(
      report.vectors, "regions", out,
      [](const VectorRow &first) { return std::to_string(first.cases); },
      [](const VectorRow &r) {
        const std::string answers = r.answered < 1 ? ", " + percent(r.answered) + " answered" : "";
        return rounded(r.error) + " (" + rounded(r.p95) + ")" + answers;
      });
  out << "\nThe time for a region in µs. The decoder also needs time to export the vectors of a "
         "frame.\n\n";
  write_by_method(
      report.vectors, "export of a frame", out,
      [](const VectorRow &first) { return rounded_or_dash(first.decoding, first.decoding != 0); },
      [](const VectorRow &r) { return rounded(r.time); });
}

constexpr double kNoticeable = 0.01; // of the error
constexpr double kFaster = 0.05;     // of the time
constexpr double kSteadier = 0.05;   // of the step
constexpr double kOfArea = 0.005;

bool is_worse_off(const AblationCell &c) {
  return c.difference.low > 0 && c.error_off > (1 + kNoticeable) * c.error;
}

bool is_better_off(const AblationCell &c) {
  return c.difference.high < 0 && c.error_off < (1 - kNoticeable) * c.error;
}

bool pays(const AblationRow &row) {
  return row.area_off < row.area - kOfArea || row.step_off > (1 + kSteadier) * row.step ||
         std::ranges::any_of(row.cells, [](const AblationCell &c) {
           return is_worse_off(c) || c.time_off > (1 + kFaster) * c.time;
         });
}

void write_ablation(const std::vector<AblationRow> &rows, std::ostream &out) {
  if (rows.empty())
    return;
  const auto head = [&](const char *more, const char *rule) {
    out << "|left out";
    for (const AblationCell &c : rows.front().cells)
      out << '|' << c.stratum;
    out << more << "|\n|---";
    for (std::size_t i = 0; i < rows.front().cells.size(); ++i)
      out << "|---";
    out << rule << "|\n";
  };
  const auto line = [&](const std::string &part, const AblationRow &row, const auto &cell) {
    out << '|' << capitalised(part);
    for (const AblationCell &c : row.cells)
      out << '|' << cell(c);
  };
  const AblationRow &first = rows.front();
  out << "The mean error (px) without one part. **Bold** means that the error is larger without "
         "the part, *italic* that it is smaller. The difference is then at least 1 %, and its 95 % "
         "interval does not contain zero. *Area* is the area under the ROC curve. *Step*: 99 % of "
         "the changes from frame to frame are smaller (px).\n\n";
  head("|area|step", "|---|---");
  line("*No part*", first, [](const AblationCell &c) { return rounded(c.error); });
  out << '|' << rounded(first.area) << '|' << rounded(first.step) << "|\n";
  for (const AblationRow &row : rows) {
    line(row.part, row, [](const AblationCell &c) {
      const char *mark = is_worse_off(c) ? "**" : is_better_off(c) ? "*" : "";
      return mark + rounded(c.error_off) + mark;
    });
    out << '|' << rounded(row.area_off) << '|' << rounded(row.step_off) << "|\n";
  }
  out << "\nThe time without one part, divided by the time with all parts. The first row has the "
         "time with all parts, in µs.\n\n";
  head("", "");
  line("*No part*", first, [](const AblationCell &c) { return rounded(c.time); });
  out << "|\n";
  for (const AblationRow &row : rows) {
    line(row.part, row,
         [](const AblationCell &c) { return rounded(c.time > 0 ? c.time_off / c.time : 0); });
    out << "|\n";
  }
  out << "\nThese parts save no error, time or step (5 %) and no area (0.005) on any stratum: ";
  std::vector<AblationRow> idle;
  std::ranges::copy_if(rows, std::back_inserter(idle), [](const auto &row) { return !pays(row); });
  out << (idle.empty() ? "none" : joined(idle, ", ", [](const auto &row) { return row.part; }))
      << ".\n";
}

void write_page(const Report &report, const fs::path &path) {
  File file(path);
  std::ostream &out = file.text();
  out << "# Results of the lab\n\n"
         "`tests/measure/lab/run.sh` writes this page. [The lab](lab.md) explains the terms. All "
         "rows are in the CSV files that the command writes to `build-lab/results/`.\n\n";
  for (const auto &[name, value] : report.circumstances)
    out << "* " << name << ": " << value << "\n";
  out << "\n## Speed and accuracy\n\n";
  write_strata(report, out);
  out << "\n## Where a peer is ahead\n\n";
  write_ahead(report, out);
  out << "\n## Everything as shipped\n\n";
  write_shipped(report, out);
  out << "\n## Scenes where a peer is ahead\n\nThe table has the scenes in which a method as "
         "shipped has a mean error (px) at least 0.01 px below `method=fast`. The bound of "
         "Cramér and Rao is for one translation. All scenes are in `scenes.csv`.\n\n";
  write_scenes(report, out);
  out << "\n## Time of `method=fast` by scene, in a stream\n\n";
  write_head(out, {"scene", "median (µs)", "99th percentile (µs)"});
  for (const StreamRow &r : report.streams)
    write_line(out, capitalised(r.scene), r.time, r.time_99);
  out << "\n## Confidence\n\n";
  write_confidence(report, out);
  const auto section = [&](const char *title, const auto &rows, const auto &body) {
    if (rows.empty())
      return;
    out << "\n## " << title << "\n\n";
    body();
  };
  section("The field of a whole frame", report.fields, [&] { write_fields(report, out); });
  section("Real clips", report.clips, [&] { write_clips(report, out); });
  section("Motion vectors of H.264", report.vectors, [&] { write_vectors(report, out); });
  section("What each part is worth", report.ablation,
          [&] { write_ablation(report.ablation, out); });
}

} // namespace

void mark_fronts(std::vector<SweepRow> &sweep) {
  for (const std::string &stratum : strata_of(sweep)) {
    std::vector<SweepRow *> rows;
    std::vector<SpeedAndError> points;
    for (SweepRow &row : sweep)
      if (row.stratum == stratum && row.threads == 1 && row.method != "always zero") {
        rows.push_back(&row);
        points.push_back({row.time, row.error});
      }
    const std::vector<bool> on_front = pareto_front(points);
    for (std::size_t i = 0; i < rows.size(); ++i)
      rows[i]->on_front = on_front[i];
  }
}

std::vector<SweepRow> dominating_peers(const std::vector<SweepRow> &sweep) {
  std::vector<SweepRow> found;
  for (const SweepRow &own : sweep)
    if (is_ours(own))
      for (const SweepRow &row : sweep)
        if (row.is_peer && row.method != "always zero" && row.threads == 1 &&
            row.stratum == own.stratum && dominates({row.time, row.error}, {own.time, own.error}))
          found.push_back(row);
  return found;
}

void write_ablation(const std::vector<AblationRow> &rows, const fs::path &folder) {
  fs::create_directories(folder);
  File page(folder / "ablation.md");
  write_ablation(rows, page.text());
  File table(folder / "ablation.csv");
  table.row("part", "stratum", "frames", "error", "error_off", "difference_low", "difference_high",
            "us", "us_off", "area", "area_off", "step", "step_off");
  for (const AblationRow &row : rows)
    for (const AblationCell &c : row.cells)
      table.row(row.part, c.stratum, c.frames, c.error, c.error_off, c.difference.low,
                c.difference.high, c.time, c.time_off, row.area, row.area_off, row.step,
                row.step_off);
}

void write(Report report, const fs::path &folder) {
  const std::vector<std::string> strata = strata_of(report.sweep);
  // In the order of the front, so that a chart can follow it.
  std::ranges::stable_sort(report.sweep, {}, [](const SweepRow &r) { return r.time; });
  std::ranges::stable_sort(report.sweep, {}, [&](const SweepRow &r) {
    return std::ranges::find(strata, r.stratum) - strata.begin();
  });
  fs::create_directories(folder);
  write_tables(report, folder);
  write_ablation(report.ablation, folder);
  write_json(report, folder / "lab.json");
  write_page(report, folder / "results.md");
}

} // namespace lab

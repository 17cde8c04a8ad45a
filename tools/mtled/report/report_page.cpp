#include "mtled/report/report_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ostream>
#include <sstream>

#include "base/number_text.h"
#include "io/output_file.h"

namespace palpate::tools {
namespace {

using Cells = std::vector<std::vector<std::string>>;

std::string verdict(bool held) { return held ? "held" : "FAILED"; }
std::string markdownVerdict(bool held) { return held ? "held" : "**FAILED**"; }

std::string limitOf(const Bound& bound) {
  return (bound.at_most ? "\u2264 " : "\u2265 ") + formatted(bound.limit, bound.unit);
}

std::string useOf(const Bound& bound) {
  const double use = bound.use();
  if (!std::isfinite(use)) return "\u2013";
  return format("%.0f %%", 100 * use);
}

/// Two digits: a time is never the same twice, and more would only be noise between two reports.
std::string timeOf(double seconds) {
  if (!(seconds >= 0)) return "\u2013";
  if (seconds < 10) return format("%.1f s", seconds);
  if (seconds < 120) return format("%.0f s", seconds);
  return format("%.0f min", seconds / 60);
}

Cells cellsOf(const std::vector<Bound>& bounds, std::string (*verdict_of)(bool)) {
  Cells cells = {{"Quantity", "Value", "Limit", "Used", "Verdict", "Limit from"}};
  for (const Bound& b : bounds)
    cells.push_back({b.quantity, formatted(b.value, b.unit), limitOf(b), useOf(b), verdict_of(b.held()), b.note});
  const auto has_note = [](const Bound& b) { return !b.note.empty(); };
  if (std::none_of(bounds.begin(), bounds.end(), has_note))
    for (auto& row : cells) row.pop_back();
  return cells;
}

Cells cellsOf(const ResultTable& table) {
  Cells cells = {table.columns};
  cells.insert(cells.end(), table.rows.begin(), table.rows.end());
  return cells;
}

/// A column of numbers is set to the right: each of its cells begins like one.
std::vector<bool> numberColumns(const Cells& cells) {
  std::vector<bool> numbers(cells.front().size(), cells.size() > 1);
  for (std::size_t r = 1; r < cells.size(); ++r)
    for (std::size_t c = 0; c < std::min(numbers.size(), cells[r].size()); ++c) {
      std::string text = cells[r][c];
      if (text.rfind("\u2264 ", 0) == 0 || text.rfind("\u2265 ", 0) == 0) text.erase(0, std::strlen("\u2264 "));
      const std::size_t first = text.find_first_not_of("+-");
      const bool number = first != std::string::npos && std::isdigit(static_cast<unsigned char>(text[first])) != 0;
      numbers[c] = numbers[c] && (number || text.empty() || text.rfind("NaN", 0) == 0 || text == "\u2013");
    }
  return numbers;
}

/// Characters, not bytes, of UTF-8 text.
std::size_t widthOf(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

void printTable(std::ostream& out, const Cells& cells) {
  const std::vector<bool> right = numberColumns(cells);
  std::vector<std::size_t> widths(right.size(), 0);
  for (const auto& row : cells)
    for (std::size_t c = 0; c < std::min(widths.size(), row.size()); ++c)
      widths[c] = std::max(widths[c], widthOf(row[c]));
  for (std::size_t r = 0; r < cells.size(); ++r) {
    std::string line = "  ";
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string text = c < cells[r].size() ? cells[r][c] : "";
      const std::string air(widths[c] - widthOf(text), ' ');
      line += (right[c] ? air + text : text + air) + "  ";
    }
    out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
    if (r > 0) continue;
    out << "  ";
    for (std::size_t c = 0; c < widths.size(); ++c)
      out << std::string(widths[c], '-') << (c + 1 < widths.size() ? "  " : "");
    out << '\n';
  }
}

/// Text that stands in one cell of a table: without line ends, and with the bars escaped.
std::string cellText(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|')
      cell += "\\|";
    else
      cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

void writeTable(std::ostream& out, const Cells& cells) {
  const std::vector<bool> right = numberColumns(cells);
  for (std::size_t r = 0; r < cells.size(); ++r) {
    out << '|';
    for (std::size_t c = 0; c < right.size(); ++c)
      out << ' ' << cellText(c < cells[r].size() ? cells[r][c] : "") << " |";
    out << '\n';
    if (r > 0) continue;
    out << '|';
    for (const bool to_right : right) out << (to_right ? " ---: |" : " --- |");
    out << '\n';
  }
  out << '\n';
}

/// A file's name as a link's target.
std::string linkTo(const std::string& file) {
  std::string link;
  for (const char c : file) link += c == ' ' ? "%20" : std::string(1, c);
  return link;
}

std::string altText(const std::string& caption) {
  std::string text;
  for (const char c : cellText(caption)) text += c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
  return text;
}

void writeParagraph(std::ostream& out, const std::string& text) {
  if (!text.empty()) out << text << "\n\n";
}

Cells summaryOf(const Report& report, bool markdown) {
  Cells cells = {{"Case", "Verdict", "Worst bound", "Value", "Limit", "Time"}};
  for (const CaseResult& one : report.cases) {
    const Bound* worst = one.worstBound();
    cells.push_back({markdown ? "[" + one.title + "](#" + one.name + ")" : one.name,
                     markdown ? markdownVerdict(one.held()) : verdict(one.held()), worst ? worst->quantity : "no bound",
                     worst ? formatted(worst->value, worst->unit) : "", worst ? limitOf(*worst) : "",
                     timeOf(one.seconds)});
  }
  return cells;
}

std::string countOf(const Report& report) {
  const auto held =
      std::count_if(report.cases.begin(), report.cases.end(), [](const CaseResult& c) { return c.held(); });
  std::size_t bounds = 0, bounds_held = 0;
  for (const CaseResult& one : report.cases)
    for (const Bound& bound : one.bounds) {
      ++bounds;
      bounds_held += bound.held();
    }
  std::ostringstream text;
  text << held << " of " << report.cases.size() << (report.cases.size() == 1 ? " case is held; " : " cases are held; ")
       << bounds_held << " of " << bounds << (bounds == 1 ? " bound." : " bounds.");
  if (report.missing > 0)
    text << " The run was ended before its last " << report.missing << (report.missing == 1 ? " case." : " cases.");
  return text.str();
}

void writeCase(std::ostream& out, const CaseResult& one) {
  out << "<a id=\"" << one.name << "\"></a>\n\n## " << one.title << "\n\n";
  writeParagraph(out, one.text);
  if (!one.reference.empty()) out << "**Reference.** " << one.reference << "\n\n";
  if (one.bounds.empty())
    out << "No bound was set: the case is not held.\n\n";
  else
    writeTable(out, cellsOf(one.bounds, markdownVerdict));
  for (const CaseFigure& figure : one.figures) {
    out << "![" << altText(figure.caption) << "](" << linkTo(figure.file) << ")\n\n";
    if (!figure.caption.empty()) out << "*" << cellText(figure.caption) << "*\n\n";
  }
  for (const ResultTable& table : one.tables) {
    if (!table.title.empty()) out << "**" << table.title << "**\n\n";
    writeTable(out, cellsOf(table));
    writeParagraph(out, table.note);
  }
}

}  // namespace

bool Report::held() const {
  return !cases.empty() && missing == 0 &&
         std::all_of(cases.begin(), cases.end(), [](const CaseResult& c) { return c.held(); });
}

void printTable(std::ostream& out, const ResultTable& table) {
  if (!table.title.empty()) out << "  " << table.title << '\n';
  printTable(out, cellsOf(table));
}

void printCase(std::ostream& out, const CaseResult& result) {
  out << result.title << "  [" << result.name << "]  " << timeOf(result.seconds) << '\n';
  if (!result.reference.empty()) out << "  reference: " << result.reference << '\n';
  for (const ResultTable& table : result.tables) {
    out << '\n';
    printTable(out, table);
  }
  out << '\n';
  if (result.bounds.empty())
    out << "  no bound was set\n";
  else
    printTable(out, cellsOf(result.bounds, verdict));
  out << "  => " << verdict(result.held()) << "\n\n";
}

void printSummary(std::ostream& out, const Report& report) {
  printTable(out, summaryOf(report, false));
  out << "\n  " << countOf(report) << '\n';
}

std::string markdownOf(const Report& report) {
  std::ostringstream out;
  out << "<!-- Written by the command below; edits are lost. -->\n\n# " << report.title << "\n\n";
  writeParagraph(out, report.intro);
  out << countOf(report) << "\n\n";
  writeTable(out, summaryOf(report, true));
  if (!report.command.empty()) out << "To repeat it:\n\n```sh\n" << report.command << "\n```\n\n";
  if (!report.build.empty())
    out << "Built as: " << report.build << ". All numbers are in [results.json](results.json).\n\n";
  for (const CaseResult& one : report.cases) writeCase(out, one);
  std::string page = out.str();
  while (page.size() > 1 && page[page.size() - 2] == '\n') page.pop_back();  // one line end closes a file
  return page;
}

void checkReport(const std::string& folder) {
  makeFolder(folder);
  for (const char* file : {"/README.md", "/results.json"}) checkWritable(folder + file);
}

void writeReport(const std::string& folder, const Report& report) {
  makeFolder(folder);
  writeWholeFile(folder + "/README.md", markdownOf(report));
  writeWholeFile(folder + "/results.json", jsonOf(report));
}

}  // namespace palpate::tools

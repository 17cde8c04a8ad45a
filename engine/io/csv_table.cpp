#include "io/csv_table.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "base/printable_text.h"
#include "io/text_file.h"
#include "io/token_reader.h"

namespace palpate {

namespace {

struct Field {
  std::string_view text;
  SourceLocation place;
};

/// What stands between the names of a table.
char separatorOf(std::string_view names) {
  for (const char separator : {',', ';', '\t'})
    if (names.find(separator) != std::string_view::npos) return separator;
  return ',';
}

/// The fields of a line, without blanks and quotes around them.
std::vector<Field> fieldsOf(std::string_view line, char separator, const std::string& file, int number) {
  std::vector<Field> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    std::size_t end = begin;
    for (bool in_quotes = false; end < line.size() && (in_quotes || line[end] != separator); ++end) {
      if (line[end] == '"') in_quotes = !in_quotes;
    }
    std::string_view text = line.substr(begin, end - begin);
    const std::size_t blanks = std::min(text.find_first_not_of(" \t"), text.size());
    text.remove_prefix(blanks);
    text = text.substr(0, text.find_last_not_of(" \t") + 1);
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
    fields.push_back({text, {file, number, static_cast<int>(begin + blanks) + 1}});
    begin = end + 1;
  }
  return fields;
}

void readHeader(const std::vector<Field>& fields, CsvTable& table) {
  table.header = {table.file, fields.front().place.line, 0};
  for (const auto& [text, place] : fields) {
    if (text.empty())
      throw InputError(place, "a column without a name", "the first line names the columns, like X,Y,Z");
    if (std::find(table.name.begin(), table.name.end(), text) != table.name.end()) {
      throw InputError(place, "two columns are named " + inQuotes(text), "rename one of them");
    }
    table.name.emplace_back(text);
  }
  table.column.resize(fields.size());
}

void readRow(const std::vector<Field>& fields, char separator, const std::function<bool(const std::string&)>& needed,
             CsvTable& table) {
  const SourceLocation& place = fields.front().place;
  if (fields.size() != table.name.size()) {
    throw InputError({table.file, place.line, 0},
                     std::to_string(fields.size()) + " fields, but " + std::to_string(table.name.size()) + " columns",
                     "separate fields as the names are; the file may have been cut short");
  }
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const auto& [text, where] = fields[k];
    const std::string& name = table.name[k];
    if (name == "trust") table.trust.emplace_back(text);
    double& value = table.column[k].emplace_back(std::numeric_limits<double>::quiet_NaN());
    if (name == "trust" || text.empty() || lowerCase(text) == "nan" || (needed && !needed(name))) continue;
    std::string number(text);
    if (separator == ';') std::replace(number.begin(), number.end(), ',', '.');
    value = parseNumber(number, where, "column " + inQuotes(name));
  }
  table.line.push_back(place.line);
}

}  // namespace

int CsvTable::find(const std::string& wanted) const {
  auto found = std::find(name.begin(), name.end(), wanted);
  if (found == name.end()) {
    found = std::find_if(name.begin(), name.end(),
                         [&](const std::string& other) { return lowerCase(other) == lowerCase(wanted); });
  }
  return found == name.end() ? -1 : static_cast<int>(found - name.begin());
}

const std::vector<double>& CsvTable::operator[](const std::string& wanted) const {
  const int k = find(wanted);
  if (k >= 0) return column[static_cast<std::size_t>(k)];
  std::string known;
  for (const std::string& other : name) known += (known.empty() ? "" : ", ") + inQuotes(other);
  throw InputError(header, "there is no column " + inQuotes(wanted), "the file has " + known);
}

CsvTable readCsvTable(const std::string& path, const SourceLocation& asked_from,
                      const std::function<bool(const std::string& name)>& needed,
                      const std::vector<std::string>& unnamed) {
  const std::string bytes = readWholeFile(path, asked_from);
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))
    throw InputError({path, 0, 0}, "a table in UTF-16", "save it as CSV in UTF-8");
  std::string_view rest = bytes;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // a byte-order mark
  CsvTable table;
  table.file = path;
  char separator = ',';
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end);
    if (!rest.empty()) rest.remove_prefix(rest.starts_with("\r\n") ? 2 : 1);
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos || line[first] == '#') continue;
    if (table.name.empty()) {
      separator = separatorOf(line);
      const bool named =
          unnamed.empty() || line.find_first_of("0123456789", first) > line.find_first_not_of("+-.", first);
      if (named) {
        readHeader(fieldsOf(line, separator, path, number), table);
        continue;
      }
      table.header = {path, number, 0};
      table.name = unnamed;
      table.column.resize(unnamed.size());
    }
    readRow(fieldsOf(line, separator, path, number), separator, needed, table);
  }
  if (table.name.empty())
    throw InputError({path, 0, 0}, "an empty file", "the first line names the columns, like X,Y,Z");
  return table;
}

}  // namespace palpate

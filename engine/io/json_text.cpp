#include "io/json_text.h"

#include <nlohmann/json.hpp>
#include <set>
#include <vector>

namespace palpate {

std::string doubledKey(const std::string& json) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string doubled;
  const nlohmann::json::parser_callback_t look = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    if (event == nlohmann::json::parse_event_t::object_start) keys.emplace_back();
    if (event == nlohmann::json::parse_event_t::object_end) keys.pop_back();
    if (event == nlohmann::json::parse_event_t::key && doubled.empty())
      if (const auto key = parsed.get<std::string>(); !keys.back().insert(key).second) doubled = key;
    return true;
  };
  [[maybe_unused]] const nlohmann::json all = nlohmann::json::parse(json, look, false);
  return doubled;
}

}  // namespace palpate

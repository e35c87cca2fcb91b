#include "twin/report/page.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>

#include "report/templates.h"
#include "twin/core/error.h"

namespace twin::report {
namespace {

using kainjow::mustache::data;
using nlohmann::json;

/// Converts JSON for the templates; values for which a section is omitted become false.
data ToData(const json& value) {
  switch (value.type()) {
    case json::value_t::object: {
      data object(data::type::object);
      for (const auto& [key, member] : value.items()) object.set(key, ToData(member));
      return object;
    }
    case json::value_t::array: {
      data list(data::type::list);
      for (const json& element : value) list.push_back(ToData(element));
      return list;
    }
    case json::value_t::string: {
      const auto& text = value.get_ref<const std::string&>();
      return text.empty() ? data(false) : data(text);
    }
    case json::value_t::boolean: return data(value.get<bool>());
    case json::value_t::number_integer:
    case json::value_t::number_unsigned: return data(value.dump());
    case json::value_t::number_float: {
      const double number = value.get<double>();
      return data(std::isfinite(number) ? fmt::format("{:.4g}", number) : std::string("none"));
    }
    default: return data(false);
  }
}

}  // namespace

json FactsOf(const std::vector<std::pair<std::string, std::string>>& facts) {
  json list = json::array();
  for (const auto& [name, text] : facts) list.push_back({{"name", name}, {"text", text}});
  return list;
}

std::string Escape(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      case '\n': html += c; break;
      default: html += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
    }
  }
  return html;
}

std::string InlineSvg(std::string_view svg, std::string_view name) {
  // gnuplot's definitions of ids and references to them.
  constexpr std::array<std::string_view, 4> kNames{" id='", " id=\"", "href='#", "url(#"};
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string_view::npos) return {};
  std::string text(svg.substr(begin));
  // Browsers show titles as tooltips, and gnuplot's have no meaning for readers.
  for (std::size_t at = text.find("<title>"); at != std::string::npos; at = text.find("<title>")) {
    constexpr std::string_view kEnd = "</title>";
    const std::size_t end = text.find(kEnd, at);
    text.erase(at, end == std::string::npos ? end : end + kEnd.size() - at);
  }
  for (const std::string_view before : kNames) {
    for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at)) {
      at += before.size();
      text.insert(at, fmt::format("{}-", name));
    }
  }
  return text;
}

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      three = three << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j <= bytes.size() ? kDigits[three >> (18 - 6 * j) & 0x3F] : '=';
    }
  }
  return text;
}

std::string RenderPage(std::string_view name, const json& data) {
  kainjow::mustache::mustache page{std::string(TemplateText(fmt::format("{}.html", name)))};
  page.set_custom_escape([](const std::string& text) { return Escape(text); });
  kainjow::mustache::data all = ToData(data);
  for (const TemplateFile& file : TemplateFiles()) {
    std::string_view part = file.name;
    if (part.ends_with(".html")) part.remove_suffix(std::string_view(".html").size());
    if (file.name.ends_with(".gp")) continue;
    TWIN_CHECK(!data.contains(part));
    all.set(std::string(part), std::string(file.text));
  }
  std::string html = page.render(all);
  TWIN_CHECK(page.is_valid() && page.error_message().empty());
  return html;
}

}  // namespace twin::report

#ifndef INSONIFY_EXAMPLES_LIVE_WEB_JSON_HPP
#define INSONIFY_EXAMPLES_LIVE_WEB_JSON_HPP

#include <insonify/geometry/pose.hpp>
#include <array>
#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace live {

class json_list;

/// Builds the text of a JSON object.
class json_object {
  public:
    json_object& add(std::string_view name, const std::string& value) {
        std::string escaped;
        for (const char c : value) {
            char code[8] = {c, 0};
            if (static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\')
                std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
            escaped += code;
        }
        return put(name, '"' + escaped + '"');
    }
    template <class Number>
    requires std::integral<Number> || std::floating_point<Number> json_object& add(std::string_view name,
                                                                                   Number value) {
        return put(name, number(value));
    }
    json_object& add(std::string_view name, const json_object& value) { return put(name, value.text()); }
    json_object& add(std::string_view name, const json_list& value);
    json_object& add(std::string_view name, const insonify::pose& at) {
        std::string columns;
        for (int i = 0; i < 3; ++i) columns += point(at.rotation[i]) + ",0,";
        return put(name, '[' + columns + point(at.translation) + ",1]");
    }
    template <std::size_t N>
    json_object& add(std::string_view name, const std::array<insonify::vec3, N>& points) {
        return add(name, std::vector<insonify::vec3>(points.begin(), points.end()));
    }
    json_object& add(std::string_view name, const std::vector<insonify::vec3>& points) {
        std::string all;
        for (const insonify::vec3& one : points) all += (all.empty() ? "[" : ",[") + point(one) + ']';
        return put(name, '[' + all + ']');
    }
    std::string text() const { return '{' + members_ + '}'; }

  private:
    static std::string number(bool value) { return value ? "true" : "false"; }
    static std::string number(std::integral auto value) { return std::to_string(value); }
    static std::string number(double value) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.7g", insonify::is_finite(static_cast<float>(value)) ? value : 0);
        return digits;
    }
    static std::string point(const insonify::vec3& p) { return number(p.x) + ',' + number(p.y) + ',' + number(p.z); }
    json_object& put(std::string_view name, const std::string& value) {
        members_ += members_.empty() ? "\"" : ",\"";
        members_.append(name).append("\":").append(value);
        return *this;
    }

    std::string members_{};
};

/// Builds the text of a JSON list of objects.
class json_list {
  public:
    void add(const json_object& one) { members_ += (members_.empty() ? "" : ",") + one.text(); }
    std::string text() const { return '[' + members_ + ']'; }

  private:
    std::string members_{};
};

inline json_object& json_object::add(std::string_view name, const json_list& value) { return put(name, value.text()); }

} // namespace live

#endif

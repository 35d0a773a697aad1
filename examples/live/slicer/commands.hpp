#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_COMMANDS_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_COMMANDS_HPP

#include "../session.hpp"
#include "requests.hpp"
#include <cctype>
#include <cmath>
#include <cstdlib>

/// From commands to events of the session, and back to answers in the words of PLUS.
namespace slicer {

/// What came of a command.
struct outcome {
    bool done = true;
    std::string sentence{};
};

namespace detail {

/// The value of an attribute, name="value", at or after a place in an XML text; empty where there is none.
inline std::string attribute(const std::string& xml, const std::string& name, std::size_t from = 0) {
    for (std::size_t at = xml.find(name, from); at != std::string::npos; at = xml.find(name, at + 1)) {
        const std::size_t open = at + name.size() + 1;
        const bool is_whole = at > 0 && std::isspace(static_cast<unsigned char>(xml[at - 1])) != 0;
        if (!is_whole || open >= xml.size() || xml[open - 1] != '=' || (xml[open] != '"' && xml[open] != '\''))
            continue;
        const std::size_t close = xml.find(xml[open], open + 1);
        return close == std::string::npos ? std::string{} : xml.substr(open + 1, close - open - 1);
    }
    return {};
}

inline std::string escaped(const std::string& text) {
    std::string safe;
    for (const char letter : text)
        if (letter == '"')
            safe += "&quot;";
        else if (letter == '&')
            safe += "&amp;";
        else if (letter == '<')
            safe += "&lt;";
        else if (letter == '>')
            safe += "&gt;";
        else
            safe += letter;
    return safe;
}

/// A parameter of PLUS's SetUsParameter as an event.
/// @throws std::invalid_argument  for one that is not known
inline live::event us_parameter(const std::string& name, const std::string& value, float depth) {
    const std::optional<live::event> read = live::parse_event("value " + value);
    if (!read || read->values.size() != 1) throw std::invalid_argument{name + " takes a number"};
    const float number = read->values[0];
    if (name == "DepthMm") return {"depth", {number}};
    if (name == "FrequencyMhz") return {"frequency", {number}};
    if (name == "DynRangeDb") return {"dynamic_range", {number}};
    if (name == "GainPercent") return {"gain", {0.6F * (number - 50)}}; // -30 to 30 dB
    if (name == "FocusDepthPercent") {                                  // to the micrometre: 100 is the depth
        const double micrometres = std::round(1e4 * static_cast<double>(number) * static_cast<double>(depth));
        return {"focus", {static_cast<float>(1e-3 * micrometres)}};
    }
    throw std::invalid_argument{"there is no parameter '" + name +
                                "'; known are DepthMm, FrequencyMhz, DynRangeDb, GainPercent and FocusDepthPercent"};
}

/// PLUS's commands: SetUsParameter with Name and Value of each parameter. Others are the session's events.
inline std::vector<live::event> xml_events(const std::string& xml, float depth) {
    const std::string name = attribute(xml, "Name");
    std::vector<live::event> events;
    if (name != "SetUsParameter") {
        const std::optional<live::event> one = live::parse_event(name + ' ' + attribute(xml, "Value"));
        if (!one) throw std::invalid_argument{"the command has no Name"};
        return {*one};
    }
    for (std::size_t at = xml.find("<Parameter"); at != std::string::npos; at = xml.find("<Parameter", at + 1))
        events.push_back(us_parameter(attribute(xml, "Name", at), attribute(xml, "Value", at), depth));
    if (events.empty()) throw std::invalid_argument{"SetUsParameter has no Parameter"};
    return events;
}

} // namespace detail

/// Applies a command: "gain 6", an event of the session a line, or PLUS's XML.
inline outcome apply(live::session& session, const command& asked) {
    try {
        std::vector<live::event> events;
        const std::string& text = asked.text.empty() ? asked.name : asked.text;
        if (text.find('<') != std::string::npos) {
            events = detail::xml_events(text, session.machine.settings.depth);
        } else {
            std::istringstream lines{text};
            for (std::string line; std::getline(lines, line);)
                if (const std::optional<live::event> one = live::parse_event(line)) events.push_back(*one);
        }
        if (events.empty()) return {false, "the command is empty; send an event such as: gain 6"};
        live::effect_check effects{session};
        for (const live::event& one : events) { // all or nothing
            if (one.name == "interval")
                throw std::invalid_argument{
                    "interval: the server's clock sets it; --fps is the number of pictures a second"};
            live::check_range(one);
            effects.add(one);
        }
        std::string done;
        for (const live::event& one : events) {
            session.apply(one);
            done += (done.empty() ? "" : "; ") + live::event_line(one);
        }
        return {true, done};
    } catch (const std::exception& fault) {
        return {false, fault.what()};
    }
}

/// The answer to a command: RTS_COMMAND to COMMAND; to STRING of the device CMD_7 a STRING of ACK_7.
inline bytes pack_outcome(const header& head, const command& asked, const outcome& result) {
    const char* const status = result.done ? "SUCCESS" : "FAIL";
    if (asked.is_string) {
        const std::size_t mark = head.device.find('_');
        return pack_string("ACK" + (mark == std::string::npos ? std::string{} : head.device.substr(mark)),
                           std::string{"<CommandReply Status=\""} + status + "\" Message=\"" +
                               detail::escaped(result.sentence) + "\" />");
    }
    metadata data{{"Status", status}, {result.done ? "Message" : "Error", result.sentence}};
    return pack_command_reply(head.version, head.device, asked.id, asked.name,
                              "<CommandReply Name=\"" + detail::escaped(asked.name) + "\" Status=\"" + status + "\" " +
                                  (result.done ? "Message=\"" : "Error=\"") + detail::escaped(result.sentence) +
                                  "\"></CommandReply>",
                              data);
}

/// The event of a pose that a tracker sends: ProbeToReference, NeedleToReference or NeedleTipToReference, whatever follows
/// "To". None for another name.
inline std::optional<live::event> pose_event(const std::string& device, const pose& at) {
    const std::string tool = device.substr(0, device.find("To"));
    live::event event{tool == "Probe" ? "hold_probe" : tool == "Needle" || tool == "NeedleTip" ? "hold_needle" : ""};
    if (event.name.empty()) return std::nullopt;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) event.values.push_back(at.rotation[column][row]);
    for (int row = 0; row < 3; ++row) event.values.push_back(1e3F * at.translation[row]);
    return event;
}

} // namespace slicer

#endif

#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_KNOBS_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_KNOBS_HPP

#include "../controls.hpp"
#include "picture.hpp"

namespace live {

/// The knobs, from the table of controls, in tabs as sonographers group them.
class knob_panel {
  public:
    bool saves_sequence = false, wants_screenshot = false;

    /// Knobs, buttons and tools; they do nothing while a recorded session turns them.
    void show(const shown_frame& frame, worker& scanner, picture_panel& picture) {
        const bool replays = frame.to_replay > 0;
        if (replays) {
            if (ImGui::Button("Take over")) scanner.stop_replay();
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("Ends the recorded session here; probe and knobs are yours");
            ImGui::SameLine();
            ImGui::TextUnformatted("A recorded session turns the knobs and moves the probe.");
        }
        ImGui::BeginDisabled(replays);
        show_case(frame, scanner);
        show_buttons(frame, scanner);
        show_tabs(frame, scanner, picture);
        ImGui::EndDisabled();
    }

  private:
    // The case by its title, and the number of the patient.
    static void show_case(const shown_frame& frame, worker& scanner) {
        const std::size_t of_case = index_of("case"), of_patient = index_of("patient");
        const control &body = controls()[of_case], &number = controls()[of_patient];
        const long present = std::lround(frame.values[of_case]);
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted(body.title.c_str());
        ImGui::SameLine(92);
        ImGui::PushItemWidth(290);
        if (ImGui::BeginCombo("##case",
                              present < 0 ? "of its own" : body.choices[static_cast<std::size_t>(present)].c_str(),
                              ImGuiComboFlags_HeightLarge)) {
            for (std::size_t k = 0; k < body.choices.size(); ++k)
                if (ImGui::Selectable(body.choices[k].c_str(), static_cast<long>(k) == present))
                    scanner.push({body.event, {static_cast<float>(k)}});
            ImGui::EndCombo();
        }
        ImGui::PopItemWidth();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", body.tooltip.c_str());
        ImGui::SameLine(0, 16);
        ImGui::TextUnformatted(number.title.c_str());
        ImGui::SameLine();
        ImGui::PushItemWidth(120);
        int patient = static_cast<int>(std::lround(frame.values[of_patient]));
        if (ImGui::InputInt("##patient", &patient, 1, 100, ImGuiInputTextFlags_EnterReturnsTrue))
            scanner.push({number.event, {static_cast<float>(patient)}});
        ImGui::PopItemWidth();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", number.tooltip.c_str());
    }

    static void show_buttons(const shown_frame& frame, worker& scanner) {
        for (const char* name : {"mode", "preset"}) {
            const std::size_t i = index_of(name);
            const control& one = controls()[i];
            const auto present = static_cast<std::size_t>(std::lround(frame.values[i]));
            ImGui::AlignTextToFramePadding();
            ImGui::TextUnformatted(one.title.c_str());
            for (std::size_t k = 0; k < one.choices.size(); ++k) {
                ImGui::SameLine(k == 0 ? 92 : 0);
                const bool active = k == present;
                if (active) ImGui::PushStyleColor(ImGuiCol_Button, ImVec4{0.15F, 0.5F, 0.75F, 1});
                if (ImGui::Button(one.choices[k].c_str())) scanner.push({one.event, {static_cast<float>(k)}});
                if (active) ImGui::PopStyleColor();
                if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", one.tooltip.c_str());
            }
            if (one.event == "mode") {
                ImGui::SameLine(0, 24);
                if (ImGui::Button(frame.frozen ? "Unfreeze" : "Freeze"))
                    scanner.push({frame.frozen ? "unfreeze" : "freeze", {}});
                if (ImGui::IsItemHovered())
                    ImGui::SetTooltip("Space. Gain and dynamic range still act on a frozen picture");
            }
        }
    }

    void show_tabs(const shown_frame& frame, worker& scanner, picture_panel& picture) {
        if (!ImGui::BeginTabBar("groups")) return;
        for (const char* group : {"Image", "Probe", "Needle", "Doppler", "Measure", "Quality"}) {
            if (!ImGui::BeginTabItem(group)) continue;
            ImGui::Columns(2, nullptr, false);
            for (std::size_t i = 0; i < controls().size(); ++i)
                if (controls()[i].group == group) knob(controls()[i], frame.values[i], scanner);
            if (group == std::string{"Needle"}) entry_sliders(frame, scanner);
            if (group == std::string{"Measure"}) measure_tools(frame, scanner, picture);
            ImGui::Columns(1);
            if (group == std::string{"Image"}) time_gain(frame, scanner);
            ImGui::EndTabItem();
        }
        ImGui::EndTabBar();
    }

    static std::size_t index_of(const std::string& name) {
        return static_cast<std::size_t>(find_control(name) - controls().data());
    }

    static void knob(const control& one, float present, worker& scanner) {
        const bool is_switch = one.choices.size() == 2;
        if (!one.is_slider() && !is_switch) return;
        float wanted = present;
        ImGui::PushItemWidth(150);
        if (is_switch) {
            bool on = present > 0.5F;
            if (ImGui::Checkbox(one.title.c_str(), &on)) scanner.push({one.event, {on ? 1.0F : 0.0F}});
        } else {
            const std::string unit = one.unit == "\u00b0" ? "deg" : one.unit;
            const std::string format = std::string{one.step < 0.1F ? "%.2f " : one.step < 1 ? "%.1f " : "%.0f "} + unit;
            if (ImGui::SliderFloat(one.title.c_str(), &wanted, one.low, one.high, format.c_str()))
                scanner.push({one.event, {one.is_relative ? wanted - present : wanted}});
        }
        ImGui::PopItemWidth();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", one.tooltip.c_str());
        ImGui::NextColumn();
    }

    // Where the needle enters the skin: as far aside as its body reaches.
    static void entry_sliders(const shown_frame& frame, worker& scanner) {
        const control& one = *find_control("entry");
        const aabb whole = frame.anatomy->box;
        if (whole.empty()) return;
        for (int axis = 0; axis < 2; ++axis) {
            vec2 entry = frame.needle_entry / 1_mm;
            ImGui::PushItemWidth(150);
            if (ImGui::SliderFloat(axis == 0 ? "Entry x" : "Entry y", &entry[axis], whole.lower[axis] / 1_mm,
                                   whole.upper[axis] / 1_mm, "%.0f mm"))
                scanner.push({one.event, {entry.x, entry.y}});
            ImGui::PopItemWidth();
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", one.tooltip.c_str());
            ImGui::NextColumn();
        }
    }

    static void time_gain(const shown_frame& frame, worker& scanner) {
        const std::size_t index = index_of("slider");
        const control& one = controls()[index];
        ImGui::TextUnformatted(one.title.c_str());
        for (std::uint32_t i = 0; i < one.parts; ++i) {
            ImGui::PushID(static_cast<int>(i));
            ImGui::SameLine(80 + 46.0F * static_cast<float>(i));
            float level = frame.parts[index][i];
            ImGui::PushItemWidth(40);
            if (ImGui::DragFloat("##", &level, 0.25F, one.low, one.high, "%.0f"))
                scanner.push({one.event, {static_cast<float>(i), level}});
            ImGui::PopItemWidth();
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("Drag: gain in dB at %u / %u of the depth", i, one.parts - 1);
            ImGui::PopID();
        }
    }

    void measure_tools(const shown_frame& frame, worker& scanner, picture_panel& picture) {
        if (ImGui::RadioButton("Distance", picture.held == picture_panel::tool::distance))
            picture.held = picture_panel::tool::distance;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Two clicks on the picture");
        if (ImGui::RadioButton("Area", picture.held == picture_panel::tool::area))
            picture.held = picture_panel::tool::area;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Click along an outline; a right click closes it");
        ImGui::TextUnformatted(frame.measured ? measured_text(*frame.measured).c_str() : "");
        ImGui::NextColumn();
        ImGui::PushItemWidth(150);
        if (ImGui::SliderInt("Cine", &cine_, 0, 31, "%d frames back"))
            scanner.push({"cine", {static_cast<float>(cine_)}});
        ImGui::PopItemWidth();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Earlier frames, while frozen");
        wants_screenshot = ImGui::Button("Screenshot");
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Writes the window to insonify_<number>.png");
        ImGui::Checkbox("Save every picture", &saves_sequence);
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Writes each frame to frame_<number>.png");
    }

    int cine_ = 0;
};

} // namespace live

#endif

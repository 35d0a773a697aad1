// The sliders, built from the session's table of controls.

const time_gain = Array.from({ length: 8 }, (_, i) => ({
    event: `slider ${i}`, group: "Time gain", title: i === 0 ? "Near" : i === 7 ? "Far" : "", unit: "dB", low: -20, high: 20, step: 1,
    value: 0, tooltip: `Gain at ${i} / 7 of the depth`,
}));

const digits = (step) => (step >= 1 ? 0 : step >= 0.1 ? 1 : 2);

export class Panel {
    constructor(controls, send) {
        this.send = send;
        this.sliders = new Map();
        const all = [...controls];
        const after = all.findLastIndex(({ group }) => group === all[0].group) + 1;
        all.splice(after, 0, ...time_gain);
        const groups = document.getElementById("groups"), tabs = document.getElementById("tabs");
        groups.replaceChildren();
        tabs.replaceChildren();
        for (const name of new Set(all.map(({ group }) => group))) {
            const group = document.createElement("fieldset"), legend = document.createElement("legend"), tab = document.createElement("button");
            legend.textContent = tab.textContent = name;
            group.append(legend, ...all.filter((one) => one.group === name).map((one) => this.slider(one)));
            group.classList.toggle("time-gain", name === time_gain[0].group);
            tab.onclick = () => {
                for (const other of groups.children) other.classList.toggle("shown", other === group);
                for (const other of tabs.children) other.setAttribute("aria-pressed", other === tab);
            };
            groups.append(group);
            tabs.append(tab);
        }
        tabs.firstChild.click();
    }

    slider(control) {
        const label = document.createElement("label"), title = document.createElement("span"), input = document.createElement("input"), output = document.createElement("output");
        label.className = "slider";
        label.title = control.tooltip;
        Object.assign(input, { type: "range", min: control.low, max: control.high, step: control.step, value: control.value, name: control.event });
        input.setAttribute("aria-label", control.title || control.tooltip);
        const one = { control, input, output, value: control.value };
        input.oninput = () => {
            const value = Number(input.value);
            this.send(`${control.event} ${control.relative ? value - one.value : value}`);
            this.set(one, value);
        };
        input.onpointerdown = () => (one.held = true);
        input.onpointerup = input.onpointercancel = () => (one.held = false);
        input.ondblclick = () => {
            input.value = control.value;
            input.oninput();
        };
        title.textContent = control.title;
        label.append(title, input, output);
        this.sliders.set(control.event, one);
        this.set(one, control.value);
        return label;
    }

    set(one, value) {
        one.value = value;
        if (!one.held) one.input.value = value;
        one.output.textContent = `${Number(value).toFixed(digits(one.control.step))} ${one.control.unit}`;
    }

    // The present values, which recorded events and the hands change as well.
    update(values) {
        for (const [event, value] of Object.entries(values)) {
            const one = this.sliders.get(event);
            if (one && !one.held && Math.abs(value - one.value) > 1e-4) this.set(one, value);
        }
    }

    reset() {
        for (const one of this.sliders.values()) this.set(one, one.control.value);
    }
}

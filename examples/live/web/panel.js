// Sliders and choices, built from the session's table of controls.

const open_groups = ["Image", "Time gain", "Needle"];

const digits = (step) => (step >= 1 ? 0 : step >= 0.1 ? 1 : 2);
const make = (tag, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
};

export class Panel {
    /** @param controls  of the session  @param send  takes a line that is an event, returns its number  @param elements  places for choices, tabs and groups */
    constructor(controls, send, { choices, tabs, groups }) {
        this.send = send;
        this.all = new Map();
        this.groups = new Map();
        const is_typed = ({ low, high, step }) => (high - low) / step > 1000;
        choices.append(...controls.filter((one) => one.choices.length || is_typed(one)).map((one) => (is_typed(one) ? this.number(one) : this.choice(one))));
        const sliders = controls.filter((one) => !one.choices.length && !is_typed(one));
        for (const name of new Set([...open_groups, ...sliders.map(({ group }) => group)])) {
            const members = sliders.filter(({ group }) => group === name);
            const group = make("details", { open: open_groups.includes(name) }, make("summary", { textContent: name }), ...members.map((one) => this.slider(one)));
            const tab = make("button", { textContent: name });
            group.classList.toggle("time-gain", name === "Time gain");
            tab.onclick = () => {
                for (const other of groups.children) other.classList.toggle("shown", other === group);
                for (const other of tabs.children) other.setAttribute("aria-pressed", other === tab);
                group.open = true;
            };
            groups.append(group);
            tabs.append(tab);
            this.groups.set(name, group);
        }
        tabs.firstElementChild.click();
    }

    slider(control) {
        const input = make("input", { type: "range", min: control.low, max: control.high, step: control.step, value: control.value, name: control.event });
        input.setAttribute("aria-label", control.title || control.tooltip);
        const one = { control, input, output: make("output"), value: control.value };
        input.oninput = () => {
            const value = Number(input.value);
            this.move(one, value);
        };
        const begin = () => {
            input.value = control.value;
            input.oninput();
        };
        input.addEventListener("pointerdown", () => (one.held = true));
        for (const name of ["pointerup", "pointercancel"]) input.addEventListener(name, () => (one.held = false));
        input.addEventListener("dblclick", begin);
        input.addEventListener("keydown", ({ key }) => key === "Delete" && begin());
        this.all.set(control.event, one);
        this.set(one, control.value);
        return make("label", { className: "slider", title: control.tooltip }, make("span", { textContent: control.title }), input, one.output);
    }

    // A few short names are buttons side by side.
    choice(control) {
        const one = { control, value: control.value }, { choices, low, event, title, tooltip } = control;
        this.all.set(event, one);
        const short = choices.map(({ name }) => name).join("").length < 25;
        if (short) {
            one.buttons = choices.map(({ name }, i) => make("button", { textContent: name, name: event, onclick: () => this.choose(one, low + i) }));
        } else {
            one.input = make("select", { name: event, onchange: ({ target }) => this.choose(one, Number(target.value)) },
                ...choices.map(({ name }, i) => make("option", { textContent: name, value: low + i })));
        }
        this.set(one, control.value);
        if (!short) return make("label", { className: "choice", title: tooltip }, make("span", { textContent: title }), one.input);
        return make("div", { className: "choice", title: tooltip, role: "group", ariaLabel: title }, make("span", { textContent: title }), ...one.buttons);
    }

    number(control) {
        const input = make("input", { type: "number", min: control.low, max: control.high, step: control.step, value: control.value, name: control.event });
        const one = { control, input, value: control.value };
        input.onchange = () => this.choose(one, Math.min(Math.max(Math.round(Number(input.value)), control.low), control.high));
        this.all.set(control.event, one);
        return make("label", { className: "choice", title: control.tooltip }, make("span", { textContent: control.title }), input);
    }

    choose(one, value) {
        one.sent = this.send(`${one.control.event} ${value}`);
        this.set(one, value);
        if (one.control.event === "mode") this.groups.get("Doppler").open = value > 0;
    }

    set(one, value) {
        one.value = value;
        one.buttons?.forEach((button, i) => button.setAttribute("aria-pressed", one.control.low + i === value));
        if (one.input && !one.held) one.input.value = value;
        if (one.output) one.output.textContent = `${Number(value).toFixed(digits(one.control.step))} ${one.control.unit}`;
    }

    // An event takes no more than its range at once, and so does a difference.
    move(one, value) {
        const { event, relative, low, high } = one.control;
        if (!relative) one.sent = this.send(`${event} ${value}`);
        for (let left = relative ? value - one.value : 0, step; Math.abs(left) > 1e-6; left -= step) {
            step = Math.min(Math.max(left, low), high);
            one.sent = this.send(`${event} ${step}`);
        }
        this.set(one, value);
    }

    // The values of a picture, which recorded events and the hands change as well. An event that was sent later is yet to act.
    update(values, applied) {
        for (const [event, value] of Object.entries(values)) {
            const one = this.all.get(event);
            if (one && !one.held && !(one.sent > applied) && Math.abs(value - one.value) > 1e-4) this.set(one, value);
        }
    }

    reset() {
        for (const one of this.all.values()) this.set(one, one.control.value);
    }
}

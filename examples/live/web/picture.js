// The ultrasound picture with depth scale, gray bar, focus mark and calliper.

const room = { left: 40, right: 34, top: 22, bottom: 22 };

// In memory: pixels come from there and go to a texture.
const context = (canvas) => canvas.getContext("2d", { willReadFrequently: true });

export class Picture {
    constructor(canvas) {
        this.canvas = canvas;
        this.pixels = document.createElement("canvas"); // the picture alone
        this.strip = document.createElement("canvas"); // M-mode or spectrum below it
        this.listen();
        new ResizeObserver(() => this.draw()).observe(canvas);
    }

    show(state, pixels, strip) {
        this.state = state;
        this.fill(this.strip, state.strip, strip);
        this.fill(this.pixels, state, pixels);
        this.draw();
    }

    fill(canvas, { width, height }, pixels) {
        if (canvas.width !== width) canvas.width = width;
        if (canvas.height !== height) canvas.height = height;
        if (width * height > 0) context(canvas).putImageData(new ImageData(new Uint8ClampedArray(pixels), width, height), 0, 0);
    }
    // Where the picture is on the canvas, and points per pixel of the picture.
    layout() {
        const { clientWidth, clientHeight } = this.canvas, { width, height, strip } = this.state;
        const below = strip.height > 0 ? 0.36 * clientHeight : 0, high = clientHeight - room.top - room.bottom - below;
        const scale = Math.min((clientWidth - room.left - room.right) / width, high / height);
        return { left: (clientWidth + room.left - room.right - width * scale) / 2, top: room.top + (high - height * scale) / 2, scale, below };
    }

    draw() {
        if (!this.state) return;
        const { width, height, pitch, top: first, focus } = this.state;
        const { clientWidth, clientHeight } = this.canvas, ratio = Math.min(devicePixelRatio, 2);
        const wide = Math.round(clientWidth * ratio), high = Math.round(clientHeight * ratio);
        if (this.canvas.width !== wide || this.canvas.height !== high) Object.assign(this.canvas, { width: wide, height: high });
        const pen = context(this.canvas), { left, top, scale } = this.layout();
        pen.setTransform(ratio, 0, 0, ratio, 0, 0);
        pen.clearRect(0, 0, clientWidth, clientHeight);
        pen.imageSmoothingQuality = "high";
        pen.drawImage(this.pixels, left, top, width * scale, height * scale);

        pen.strokeStyle = pen.fillStyle = "#aeb6c2";
        pen.font = "11px system-ui, sans-serif";
        pen.textAlign = "right";
        pen.textBaseline = "middle";
        const y_of = (depth) => top + (depth - first) / pitch * scale;
        const last = first + height * pitch, every = last > 0.1 ? 20 : 10;
        pen.beginPath();
        for (let mm = 0; mm <= 1e3 * last; mm += every / 2) {
            const y = Math.round(y_of(1e-3 * mm)) + 0.5, is_long = mm % every === 0;
            pen.moveTo(left - (is_long ? 9 : 5), y);
            pen.lineTo(left - 2, y);
            if (is_long) pen.fillText(mm, left - 12, y);
        }
        pen.stroke();
        pen.fillText("mm", left - 12, top - 9);

        const right = left + width * scale;
        if (focus > 0) {
            const y = y_of(focus);
            pen.fillStyle = "#ffc83d";
            pen.beginPath();
            pen.moveTo(right + 2, y);
            pen.lineTo(right + 10, y - 5);
            pen.lineTo(right + 10, y + 5);
            pen.fill();
        }
        const greys = pen.createLinearGradient(0, top, 0, top + 120);
        greys.addColorStop(0, "#fff");
        greys.addColorStop(1, "#000");
        pen.fillStyle = greys;
        pen.fillRect(right + 16, top, 9, 120);
        pen.strokeStyle = "#4a5361";
        pen.strokeRect(right + 15.5, top - 0.5, 10, 121);
        pen.fillStyle = "#ffc83d"; // the side of the probe's mark
        pen.beginPath();
        pen.arc(left + 5, top - 9, 4, 0, 7);
        pen.fill();
        if (this.state.strip.height > 0) this.draw_strip(pen);
        this.draw_measured(pen, left, top, scale);
    }

    draw_strip(pen) {
        const { clientWidth, clientHeight } = this.canvas, { upper, lower, unit, seconds } = this.state.strip, { below } = this.layout();
        const top = clientHeight - below + 4, width = clientWidth - room.left - room.right, height = below - room.bottom - 4;
        pen.drawImage(this.strip, room.left, top, width, height);
        pen.fillStyle = pen.strokeStyle = "#aeb6c2";
        pen.textAlign = "right";
        for (const share of [0, 0.5, 1]) pen.fillText((upper + share * (lower - upper)).toFixed(0), room.left - 6, top + 5 + share * (height - 10));
        if (lower < 0) {
            const zero = top + height * upper / (upper - lower);
            pen.fillRect(room.left, zero, width, 0.5);
        }
        pen.textAlign = "left";
        pen.fillText(unit, clientWidth - room.right + 4, top + 5);
        pen.fillText(`${seconds.toFixed(1)} s`, clientWidth - room.right + 4, top + height - 5);
    }

    // What is measured: by the calliper, or by a recorded session.
    draw_measured(pen, left, top, scale) {
        const { measured, pitch } = this.state, own = this.calliper;
        if (!own && !measured) return;
        const { points, closed, text } = own ? { points: own } : measured;
        const at = points.map(({ x, y }) => [left + x * scale, top + y * scale]);
        pen.strokeStyle = pen.fillStyle = "#7dffb0";
        pen.setLineDash([4, 3]);
        pen.beginPath();
        for (const [x, y] of at) pen.lineTo(x, y);
        if (closed) pen.closePath();
        pen.stroke();
        pen.setLineDash([]);
        pen.beginPath();
        for (const [x, y] of at) {
            pen.moveTo(x - 5, y);
            pen.lineTo(x + 5, y);
            pen.moveTo(x, y - 5);
            pen.lineTo(x, y + 5);
        }
        pen.stroke();
        const [p, q] = points, edge = (side, i) => Math[side](...at.map((one) => one[i]));
        pen.font = "bold 13px system-ui, sans-serif";
        pen.textAlign = "left";
        pen.fillText(text ?? `${(1e3 * pitch * Math.hypot(p.x - q.x, p.y - q.y)).toFixed(1)} mm`, Math.min(edge("max", 0) + 8, this.canvas.clientWidth - 62), edge("min", 1) - 8);
    }

    // Keys, where the picture has the focus: arrows move one end of the calliper, with Shift the other. Returns whether it is one
    // of them.
    steer(key, shift) {
        const step = { ArrowLeft: [-2, 0], ArrowRight: [2, 0], ArrowUp: [0, -2], ArrowDown: [0, 2] }[key];
        if (!step && key !== "Escape") return false;
        const middle = { x: this.state.width / 2, y: this.state.height / 2 }, ends = this.calliper ?? [middle, middle], moved = shift ? 0 : 1;
        this.calliper = step && ends.map(({ x, y }, i) => (i === moved ? { x: x + step[0], y: y + step[1] } : { x, y }));
        this.draw();
        return true;
    }

    listen() {
        let from;
        const pixel = (event) => {
            const box = this.canvas.getBoundingClientRect(), { left, top, scale } = this.layout();
            return { x: (event.clientX - box.left - left) / scale, y: (event.clientY - box.top - top) / scale };
        };
        this.canvas.addEventListener("pointerdown", (event) => {
            if (!this.state) return;
            this.canvas.setPointerCapture(event.pointerId);
            from = pixel(event);
            this.calliper = undefined; // a click clears it
            this.draw();
        });
        this.canvas.addEventListener("pointermove", (event) => {
            if (!from) return;
            this.calliper = [from, pixel(event)];
            this.draw();
        });
        for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => (from = undefined));
    }
}

// The anatomy, the probe with its picture, and the needle, in WebGL. World coordinates are those of the session: metres,
// z is depth.
import {
    Box3, BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, Color, CylinderGeometry, DirectionalLight, DoubleSide, FrontSide, Group,
    HemisphereLight, LineBasicMaterial, LineLoop, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial,
    PerspectiveCamera, Plane, Raycaster, Scene, SphereGeometry, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";

const gauge_colours = { 18: 0xf06fa5, 19: 0xf3e9d0, 20: 0xf2cf3c, 21: 0x2f9e5b, 22: 0x33373d, 23: 0x3a7bd5, 24: 0x7a4fa3, 25: 0xf0862e };
export class Space {
    /** @param send  takes a line that is an event of the session  @param report  takes a sentence for the user */
    constructor(canvas, send, report) {
        this.canvas = canvas;
        this.send = send;
        this.tool = "slide";
        try {
            this.renderer = new WebGLRenderer({ canvas, antialias: devicePixelRatio < 2 });
        } catch {
            report("The 3-D view needs WebGL, which this browser refuses; picture, controls and keys work without it");
        }
        this.renderer?.setClearColor(0x1a1f27);
        if (this.renderer) this.renderer.localClippingEnabled = true;
        this.cuts = true; // leaves out what hides the picture
        this.seen_side = new Plane();
        this.scene = new Scene();
        this.camera = new PerspectiveCamera(32, 1, 0.005, 20);
        this.camera.up.set(0, 0, -1);
        this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x555566, 1.6));
        const lamp = new DirectionalLight(0xffffff, 1.8);
        lamp.position.set(-0.4, 0.6, 1);
        this.camera.add(lamp);
        this.anatomy = new Group();
        this.scene.add(this.anatomy);
        this.make_probe();
        this.make_needle();
        this.make_slice();
        this.show_anatomy([]);
        this.listen();
        new ResizeObserver(() => this.resize()).observe(canvas);
        this.resize();
    }

    make_probe() {
        const plastic = new MeshLambertMaterial({ color: 0x4d86bd });
        this.head = new Mesh(new BufferGeometry(), new MeshLambertMaterial({ color: 0x4d86bd, flatShading: true, side: DoubleSide }));
        this.neck = new Mesh(new CylinderGeometry(0.0305, 0.015, 0.014, 4, 1).rotateY(Math.PI / 4), plastic); // a frustum
        this.neck.geometry.rotateX(Math.PI / 2).scale(1, 0.42, 1);
        this.neck.position.z = -0.023;
        const handle = new Mesh(new CylinderGeometry(0.0105, 0.0115, 0.034, 24).rotateX(-Math.PI / 2).scale(1, 0.75, 1), plastic);
        handle.position.z = -0.047;
        const cable = new Mesh(new CylinderGeometry(0.0028, 0.0028, 0.025, 12).rotateX(Math.PI / 2), new MeshLambertMaterial({ color: 0x2b3038 }));
        cable.position.z = -0.076;
        this.mark = new Mesh(new SphereGeometry(0.0022, 16, 12), new MeshLambertMaterial({ color: 0xffc83d, emissive: 0x664400 }));
        this.probe = new Group();
        this.probe.add(this.head, this.neck, handle, cable, this.mark);
        this.probe.matrixAutoUpdate = false;
        this.probe.userData.grip = plastic;
        this.scene.add(this.probe);
    }

    make_needle() {
        this.steel = new MeshLambertMaterial({ color: 0xdfe6ee, emissive: 0x30363e, flatShading: true, side: DoubleSide });
        this.shaft = new Mesh(new BufferGeometry(), this.steel);
        this.hub = new Mesh(new CylinderGeometry(0.0032, 0.0022, 0.014, 20).rotateX(Math.PI / 2), new MeshLambertMaterial({ color: 0x33373d }));
        this.hub.position.z = -0.086;
        this.hub.rotation.x = Math.PI;
        const grip = new Mesh(new CylinderGeometry(0.004, 0.004, 0.095, 8).rotateX(Math.PI / 2), new MeshBasicMaterial({ visible: false }));
        grip.position.z = -0.0475;
        this.needle = new Group();
        this.needle.add(this.shaft, this.hub, grip);
        this.needle.matrixAutoUpdate = false;
        this.needle.userData.grip = this.steel;
        this.scene.add(this.needle);
    }

    make_slice() {
        const corners = new BufferAttribute(new Float32Array(12), 3);
        const plane = new BufferGeometry().setAttribute("position", corners);
        plane.setAttribute("uv", new BufferAttribute(new Float32Array([0, 1, 1, 1, 1, 0, 0, 0]), 2)).setIndex([0, 1, 2, 0, 2, 3]);
        this.corners = corners;
        this.slice_paint = new MeshBasicMaterial({ side: DoubleSide, transparent: true, opacity: 0.93, alphaTest: 0.5 }); // beside a sector there is nothing
        const slice = new Mesh(plane, this.slice_paint);
        this.outline = new LineLoop(new BufferGeometry(), new LineBasicMaterial({ color: 0x66ccff }));
        slice.frustumCulled = this.outline.frustumCulled = false;
        slice.renderOrder = 1;
        this.scene.add(slice, this.outline);
    }

    /** @param begins  the probe begins at the origin of the world */
    show_anatomy(parts, begins = false) {
        for (const old of this.anatomy.children) {
            old.geometry.dispose();
            old.material.dispose();
        }
        this.anatomy.clear();
        const box = new Box3();
        for (const { positions, faces, colour, opacity, cut } of parts) {
            const is_layer = opacity < 1;
            const shape = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3));
            shape.setIndex(new BufferAttribute(faces, 1)).computeVertexNormals();
            shape.computeBoundingBox();
            box.union(shape.boundingBox);
            const mesh = new Mesh(shape, new MeshLambertMaterial({ color: new Color().setRGB(...colour[0], SRGBColorSpace), opacity, transparent: is_layer, depthWrite: !is_layer, side: is_layer ? FrontSide : DoubleSide, clippingPlanes: cut && !is_layer ? [this.seen_side] : null }));
            mesh.renderOrder = is_layer ? 2 : 0;
            this.anatomy.add(mesh);
        }
        // The camera sees the whole of a small anatomy and the probe above it, and of a large one what is below the probe.
        if (box.isEmpty()) box.set(new Vector3(), new Vector3());
        box.min.z -= 0.085;
        const near = 0.14, target = box.getCenter(new Vector3()), all = target.distanceTo(box.max), radius = begins ? Math.min(all, near) : all;
        if (radius < all) target.set(0, 0, 0.03);
        this.home = { yaw: -0.42, pitch: 0.42, distance: 3.3 * radius, target };
        this.reset_camera();
    }

    /** The head of a probe, in coordinates of the probe. */
    show_probe({ positions, faces }) {
        this.head.geometry.dispose();
        this.head.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(faces, 1));
        this.head.geometry.computeVertexNormals();
        this.head.geometry.computeBoundingBox();
        const { min, max } = this.head.geometry.boundingBox;
        this.neck.scale.set(max.x / 0.021, max.y / 0.006, 1);
        this.neck.position.z = min.z - 0.004;
        this.mark.position.set(min.x + 0.003, max.y, -0.012);
    }

    show_needle({ positions, faces }) {
        this.shaft.geometry.dispose();
        this.shaft.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(faces, 1));
        this.shaft.geometry.computeVertexNormals();
    }

    /** @param picture  canvas with the ultrasound picture */
    show(state, picture) {
        this.state = state;
        this.probe.matrix.fromArray(state.probe);
        this.needle.matrix.fromArray(state.needle);
        this.probe.matrixWorldNeedsUpdate = this.needle.matrixWorldNeedsUpdate = true;
        this.hub.material.color.set(gauge_colours[state.values.gauge] ?? 0x33373d);
        this.corners.array.set(state.corners.flat());
        this.corners.needsUpdate = true;
        this.outline.geometry.dispose();
        this.outline.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(state.outline.flat()), 3));
        if (this.texture?.image !== picture || this.texture_size !== picture.width * picture.height) {
            this.texture?.dispose();
            this.texture = new CanvasTexture(picture);
            this.texture.colorSpace = SRGBColorSpace;
            this.texture_size = picture.width * picture.height;
            this.slice_paint.map = this.texture;
            this.slice_paint.needsUpdate = true;
        }
        this.texture.needsUpdate = true;
        // Ten times per second suffices where nothing but the picture changes.
        const place = String([state.probe, state.needle]);
        if (place !== this.place) this.draw_soon();
        else this.timer ??= setTimeout(() => this.draw_soon(), 100);
        this.place = place;
    }

    reset_camera() {
        this.view = { ...this.home };
        this.draw_soon();
    }

    resize() {
        const { clientWidth: width, clientHeight: height } = this.canvas;
        this.renderer?.setPixelRatio(Math.min(devicePixelRatio, 2));
        this.renderer?.setSize(width, height, false);
        this.camera.aspect = width / Math.max(height, 1);
        this.draw_soon();
    }

    draw_soon() {
        if (this.asked) return;
        this.asked = true;
        requestAnimationFrame(() => {
            this.asked = false;
            clearTimeout(this.timer);
            this.timer = undefined;
            this.place_camera();
            this.renderer?.render(this.scene, this.camera);
        });
    }

    // From +y, with depth down: x to the right, as in the picture. A narrow window is further away.
    place_camera() {
        const { yaw, pitch, distance, target } = this.view;
        const away = distance * Math.max(1, 1.1 / this.camera.aspect);
        this.camera.position.set(Math.cos(pitch) * Math.sin(yaw), Math.cos(pitch) * Math.cos(yaw), -Math.sin(pitch));
        this.camera.position.multiplyScalar(away).add(target);
        this.camera.lookAt(target);
        this.camera.updateProjectionMatrix();
        this.camera.updateMatrixWorld();
        this.place_cut();
    }

    // What is cut is seen on the side of the picture's plane that is away from the camera; everywhere where nothing is cut.
    place_cut() {
        this.seen_side.set(new Vector3(), 1);
        if (!this.cuts || !this.state) return;
        const [a, b, , d] = this.state.corners.map((corner) => new Vector3(...corner));
        this.seen_side.setFromCoplanarPoints(a, b, d);
        if (this.seen_side.distanceToPoint(this.camera.position) > 0) this.seen_side.negate();
    }

    ray(event) {
        const box = this.canvas.getBoundingClientRect();
        const at = new Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
        const caster = new Raycaster();
        this.place_camera();
        caster.setFromCamera(at, this.camera);
        return caster;
    }

    // Pixels of a point on the canvas.
    on_canvas(point) {
        const at = point.clone().project(this.camera);
        return new Vector2(at.x * this.canvas.clientWidth / 2, -at.y * this.canvas.clientHeight / 2);
    }

    grabbed(event) {
        const hit = this.ray(event).intersectObjects([this.probe, this.needle])[0];
        if (!hit) return undefined;
        let part = hit.object;
        while (part.parent !== this.scene) part = part.parent;
        return { part, point: hit.point };
    }

    highlight(part) {
        if (this.lit === part) return;
        this.lit?.userData.grip.emissive.set(this.lit === this.needle ? 0x30363e : 0);
        part?.userData.grip.emissive.set(0x2a5a86);
        this.lit = part;
        this.canvas.style.cursor = part ? "grab" : "move";
        this.draw_soon();
    }

    listen() {
        const fingers = new Map();
        let drag;
        const spread = () => {
            const [a, b] = [...fingers.values()];
            return Math.hypot(a.x - b.x, a.y - b.y);
        };
        this.canvas.addEventListener("pointerdown", (event) => {
            this.canvas.setPointerCapture(event.pointerId);
            fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
            if (fingers.size === 1) {
                const held = event.button === 0 ? this.grabbed(event) : undefined;
                drag = { ...held, last: { x: event.clientX, y: event.clientY } };
                if (held) this.highlight(held.part);
            } else {
                drag = { part: undefined, spread: spread() };
            }
        });
        this.canvas.addEventListener("pointermove", (event) => {
            if (!fingers.has(event.pointerId)) {
                if (event.pointerType === "mouse") this.highlight(this.grabbed(event)?.part);
                return;
            }
            fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
            if (fingers.size > 1) {
                const now = spread();
                this.zoom(drag.spread / Math.max(now, 1));
                drag.spread = now;
                return;
            }
            if (!drag?.last) return;
            const x = event.clientX - drag.last.x, y = event.clientY - drag.last.y;
            drag.last = { x: event.clientX, y: event.clientY };
            if (drag.part === this.probe) this.drag_probe(event, drag, x, y);
            else if (drag.part === this.needle && (event.shiftKey || this.moves_entry)) this.drag_entry(event, drag);
            else if (drag.part === this.needle) this.drag_needle(x, y);
            else this.turn(x, y);
        });
        const release = (event) => {
            fingers.delete(event.pointerId);
            drag = undefined;
            this.highlight(undefined);
        };
        this.canvas.addEventListener("pointerup", release);
        this.canvas.addEventListener("pointercancel", release);
        this.canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        this.canvas.addEventListener("dblclick", () => this.reset_camera());
        this.canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            this.zoom(Math.exp(0.001 * event.deltaY));
        }, { passive: false });
    }

    zoom(factor) {
        this.view.distance = Math.min(Math.max(this.view.distance * factor, 0.03), 3 * this.home.distance);
        this.draw_soon();
    }

    turn(x, y) {
        this.view.yaw -= 0.008 * x;
        this.view.pitch = Math.min(Math.max(this.view.pitch + 0.008 * y, -1.5), 1.5);
        this.draw_soon();
    }

    // Keys, where the view has the focus; returns whether it is one of them.
    steer(key, shift) {
        const arrow = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }[key];
        if (shift && arrow) this.turn(...arrow);
        else if (key === "+" || key === "-") this.zoom(key === "+" ? 0.9 : 1 / 0.9);
        else if (key === "Home") this.reset_camera();
        else return false;
        return true;
    }

    // Slides so that the point that was grabbed stays below the pointer, at its height; or turns.
    drag_probe(event, drag, x, y) {
        const tool = event.shiftKey ? "tilt" : event.ctrlKey ? "rotate" : this.tool;
        if (tool === "tilt") {
            if (x) this.send(`rock ${(-0.25 * x).toFixed(3)}`);
            if (y) this.send(`tilt ${(-0.25 * y).toFixed(3)}`);
        } else if (tool === "rotate") {
            if (x) this.send(`rotate ${(-0.5 * x).toFixed(3)}`);
        } else {
            const height = new Plane(new Vector3(0, 0, 1), -drag.point.z);
            const now = this.ray(event).ray.intersectPlane(height, new Vector3());
            if (!now) return;
            const step = now.clone().sub(drag.point);
            if (step.length() > 0.05) return; // near the horizon
            this.send(`slide ${(1e3 * step.x).toFixed(3)} ${(1e3 * step.y).toFixed(3)}`);
            drag.point = now;
        }
    }

    // The needle enters elsewhere: by the movement at the height of its entry.
    drag_entry(event, drag) {
        const [x, y, z] = this.state.entry[0];
        const now = this.ray(event).ray.intersectPlane(new Plane(new Vector3(0, 0, 1), -z), new Vector3());
        if (!now) return;
        drag.from ??= { at: now, x, y };
        const step = now.clone().sub(drag.from.at);
        if (step.length() > 0.3) return; // near the horizon
        this.send(`entry ${(1e3 * (drag.from.x + step.x)).toFixed(3)} ${(1e3 * (drag.from.y + step.y)).toFixed(3)}`);
    }

    // Advances by the movement along the needle, as it is seen.
    drag_needle(x, y) {
        const at = new Matrix4().fromArray(this.state.needle), tip = new Vector3().setFromMatrixPosition(at);
        const along = new Vector3().setFromMatrixColumn(at, 2);
        const seen = this.on_canvas(tip.clone().addScaledVector(along, 0.01)).sub(this.on_canvas(tip));
        const pixels = Math.max(seen.lengthSq(), 100);
        this.send(`advance ${(10 * (x * seen.x + y * seen.y) / pixels).toFixed(3)}`);
    }

    /** Where the middle of the probe's handle, or the shaft of the needle, is seen on the page: for tests. */
    seen(name) {
        this.place_camera();
        const point = (name === "probe" ? this.probe : this.needle).localToWorld(new Vector3(0, 0, name === "probe" ? -0.03 : -0.035));
        const box = this.canvas.getBoundingClientRect(), at = this.on_canvas(point);
        return { x: box.left + box.width / 2 + at.x, y: box.top + box.height / 2 + at.y };
    }
}

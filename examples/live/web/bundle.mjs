// Bundles the page's scripts with what they use of three.js, without shaders of materials that the page does not have, and
// without JSON, which it neither writes nor reads:
// node bundle.mjs MODULES PAGE OUTPUT
import { createRequire } from "node:module";
import fs from "node:fs";
import path from "node:path";

const [modules, page, output] = process.argv.slice(2);
const { build } = createRequire(path.join(modules, "bundle.mjs"))("esbuild");

const unused_chunks = /(lights_physical(_pars)?_fragment|transmission(_pars)?_fragment|iridescence_fragment|shadowmap_pars_fragment|lightprobes_pars_fragment|cube_uv_reflection_fragment|envmap_physical_pars_fragment|tonemapping_pars_fragment|lights_toon_pars_fragment|lights_phong_pars_fragment|shadowmap(_pars)?_vertex|shadowmask_pars_fragment|alphahash(_pars)?_fragment|bumpmap_pars_fragment|batching(_pars)?_vertex|envmap(_pars|_common_pars)?_(vertex|fragment)|lights_fragment_maps|displacementmap(_pars)?_vertex|morph[a-z]*(_pars)?_vertex|skin[a-z]*(_pars)?_vertex)\.glsl\.js$/;
// Of environments, glasses, shadows, groups of uniforms, morphing and passes after the picture.
const unused_modules = /(PMREMGenerator|DFGLUTData|WebXRManager|WebGLShadowMap|WebGLUniformsGroups|WebGLOutput|WebGLEnvironments|WebGLMorphtargets)\.js$/;
const absent = `export class PMREMGenerator {}
export const getDFGLUT = () => null;
export class WebXRManager { enabled = false; isPresenting = false; addEventListener() {} getEnvironmentBlendMode() {} }
export class WebGLShadowMap { enabled = false; render() {} }
export class WebGLUniformsGroups {}
export class WebGLOutput {}
export class WebGLEnvironments { get() { return null; } dispose() {} }
export class WebGLMorphtargets {}`;
const json_methods = /^\t(to|from)JSON\([\s\S]*?^\t}$/gm;
const with_json = /three.src.(cameras|core|lights|materials|math|objects|scenes|textures)..*\.js$/;
const unused_shaders = /(meshphysical|meshphong|meshtoon|meshmatcap|meshnormal|distance|depth|shadow|sprite|points|equirect|linedashed|vsm)\.glsl\.js$/;

await build({
    entryPoints: [page],
    outfile: output,
    bundle: true,
    minify: true,
    format: "esm",
    legalComments: "none",
    alias: { three: path.join(modules, "three/src/Three.js") },
    plugins: [{
        name: "unused",
        setup({ onLoad }) {
            onLoad({ filter: unused_chunks }, () => ({ contents: 'export default ""' }));
            onLoad({ filter: unused_modules }, () => ({ contents: absent }));
            onLoad({ filter: with_json }, ({ path: file }) => ({ contents: fs.readFileSync(file, "utf8").replace(json_methods, "") }));
            onLoad({ filter: unused_shaders }, () => ({ contents: 'export const vertex = "", fragment = ""' }));
        },
    }],
});

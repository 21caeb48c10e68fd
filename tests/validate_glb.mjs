// Runs Khronos' glTF validator over files: node validate_glb.mjs FILE...
// Run it from a folder whose node_modules has gltf-validator. Exit status: 0 without errors, 1 with errors, 2 for wrong use.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const SEVERITIES = ["error", "warning", "information", "hint"];
// The extension's tables are buffer views that no accessor uses.
const IGNORED = ["UNUSED_OBJECT"];

const files = process.argv.slice(2);
if (files.length === 0) {
    console.error("usage: node validate_glb.mjs FILE...");
    process.exit(2);
}
const { validateBytes } = createRequire(join(process.cwd(), "package.json"))("gltf-validator");

let errorCount = 0;
for (const file of files) {
    try {
        const options = { uri: file, maxIssues: 100, ignoredIssues: IGNORED };
        const { issues } = await validateBytes(new Uint8Array(await readFile(file)), options);
        for (const { severity, code, message, pointer } of issues.messages) {
            console.log(`${file}: ${SEVERITIES[severity]}: ${code}: ${message} ${pointer ?? ""}`);
        }
        console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
        errorCount += issues.numErrors;
    } catch (reason) {
        // The validator gives up on what is no glTF at all.
        console.log(`${file}: error: ${reason}`);
        errorCount += 1;
    }
}
process.exit(errorCount > 0 ? 1 : 0);

// Writes src/api/schema.d.ts from api_schema/ (the HTTP interface and the job kinds), or with --check says whether it
// is still the same.
import { readdir, readFile, writeFile } from "node:fs/promises";
import { isDeepStrictEqual } from "node:util";
import openapiTS, { astToString } from "openapi-typescript";

const source = new URL("../../../api_schema/", import.meta.url);
const target = new URL("../src/api/schema.d.ts", import.meta.url);

const read = async (name) => JSON.parse(await readFile(new URL(name, source), "utf8"));
const document = await read("openapi.json");

// A job's parameters and result are open in the interface, as kinds can be added; the known ones have schemas beside it.
for (const name of (await readdir(new URL("jobs/", source))).sort()) {
  const { params, result } = await read(`jobs/${name}`);
  for (const schema of [params, result]) {
    const { $defs = {}, ...whole } = JSON.parse(JSON.stringify(schema).replaceAll("#/$defs/", "#/components/schemas/"));
    for (const [title, part] of Object.entries({
      ...$defs,
      [whole.title]: whole,
    })) {
      const known = document.components.schemas[title];
      if (known && !isDeepStrictEqual(known, part)) throw new Error(`two schemas are called ${title}`);
      document.components.schemas[title] = part;
    }
  }
}

const types = `// Generated from api_schema/ by \`npm run api\`.\n\n${astToString(
  await openapiTS(document, { alphabetize: true, defaultNonNullable: true }),
)}`;

if (process.argv.includes("--check")) {
  const recorded = await readFile(target, "utf8").catch(() => "");
  if (recorded !== types) {
    console.error("src/api/schema.d.ts differs from api_schema/: run `npm run api`.");
    process.exit(1);
  }
} else {
  await writeFile(target, types);
}

import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import react from "@vitejs/plugin-react";
import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));

/** Lays a compressed copy beside each file that gets smaller by it: the gateway serves those, and compresses nothing. */
function compressed(): Plugin {
  let folder = "";
  return {
    name: "compressed",
    apply: "build",
    configResolved(config) {
      folder = resolve(config.root, config.build.outDir);
    },
    closeBundle() {
      for (const name of readdirSync(folder, { recursive: true, encoding: "utf8" })) {
        const file = join(folder, name);
        if (!/\.(js|css|html|svg|json)$/.test(name) || !statSync(file).isFile()) continue;
        const content = readFileSync(file);
        const smaller = gzipSync(content, { level: 9 });
        if (smaller.length < 0.9 * content.length) writeFileSync(`${file}.gz`, smaller);
      }
    },
  };
}

export default defineConfig({
  plugins: [react(), compressed()],
  resolve: { alias: { "@": path("./src") } },
  build: {
    // The gateway serves this folder; its image build chooses another with --outDir.
    outDir: path("../gateway/shapery_gateway/static"),
    emptyOutDir: true,
    target: "es2023",
    // Nothing small becomes a data: address, which the content-security policy would refuse for fonts and scripts.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 2500,
  },
  // Workers fetch their parts when they need them, as pages do.
  worker: { format: "es" },
  server: {
    // `npm run dev` beside a running platform: SHAPERY_SERVER names its address.
    proxy: Object.fromEntries(
      ["/v1", "/readyz"].map((path) => [path, process.env.SHAPERY_SERVER ?? "http://127.0.0.1:8000"]),
    ),
  },
  test: {
    include: ["src/**/*.test.ts", "tests/**/*.test.ts"],
    environment: "node",
    // Threads that keep what they have read: no test leaves anything behind that another one minds.
    pool: "threads",
    isolate: false,
    testTimeout: 60_000, // on a machine that does other things as well
  },
});

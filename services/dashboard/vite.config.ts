import { fileURLToPath } from "node:url";
import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));

export default defineConfig({
  plugins: [react()],
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
  server: {
    // `npm run dev` beside a running platform: SHAPERY_SERVER names its address.
    proxy: Object.fromEntries(
      ["/v1", "/readyz"].map((path) => [path, process.env.SHAPERY_SERVER ?? "http://127.0.0.1:8000"]),
    ),
  },
  test: {
    include: ["src/**/*.test.ts", "tests/**/*.test.ts"],
    environment: "node",
    testTimeout: 60_000, // on a machine that does other things as well
  },
});

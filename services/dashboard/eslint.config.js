import hooks from "eslint-plugin-react-hooks";
import { defineConfig, globalIgnores } from "eslint/config";
import tseslint from "typescript-eslint";

export default defineConfig(
  globalIgnores(["dist", "src/api/schema.d.ts"]),
  tseslint.configs.strict,
  {
    files: ["src/**/*.{ts,tsx}", "tests/**/*.ts"],
    extends: [tseslint.configs.strictTypeCheckedOnly],
    languageOptions: { parserOptions: { projectService: true } },
    rules: {
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true }],
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
      // The browser's own types promise what an old browser, or a page without HTTPS, does not have.
      "@typescript-eslint/no-unnecessary-condition": "off",
      // Aborted requests and databases reject with what the browser gives them.
      "@typescript-eslint/prefer-promise-reject-errors": "off",
    },
  },
  hooks.configs.flat["recommended-latest"],
  { rules: { "no-console": "error", eqeqeq: "error" } },
  { files: ["scripts/**"], rules: { "no-console": "off" } },
  { files: ["tests/**"], rules: { "@typescript-eslint/require-await": "off" } },
);

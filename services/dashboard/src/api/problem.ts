/** `application/problem+json` (RFC 9457), as the gateway's one error handler writes it. */
export interface Problem {
  status: number;
  detail: string;
  code: string;
  hint: string;
  request_id: string;
  errors?: unknown;
}

/** The server answered with an error. */
export class ApiError extends Error {
  override readonly name = "ApiError";
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
    readonly hint: string,
    readonly requestId = "",
    /** The whole answer, for those who know more of its form. */
    readonly problem: unknown = null,
  ) {
    super(message);
  }
}

/** The server did not answer. */
export class Unreachable extends Error {
  override readonly name = "Unreachable";
  constructor(cause?: unknown) {
    super("The server does not answer.", { cause });
  }
}

interface Field {
  location: string;
  message: string;
}

function isField(value: unknown): value is Field {
  return typeof value === "object" && value !== null && "location" in value && "message" in value;
}

/** Read an error from a response's body, whatever a proxy on the way may have made of it. */
export function problemFrom(status: number, body: unknown): ApiError {
  if (typeof body === "string") {
    try {
      body = JSON.parse(body);
    } catch {
      body = null; // a proxy's page, not ours
    }
  }
  if (typeof body === "object" && body !== null && "detail" in body && typeof body.detail === "string") {
    const problem = body as Partial<Problem> & { detail: string };
    const fields: Field[] = Array.isArray(problem.errors) ? problem.errors.filter(isField) : [];
    const detail = fields.length
      ? `${problem.detail} ${fields.map((field) => `${field.location}: ${field.message}`).join("; ")}`
      : problem.detail;
    const { code = `http_${status}`, hint = "", request_id = "" } = problem;
    return new ApiError(status, code, detail, hint, request_id, body);
  }
  return new ApiError(status, `http_${status}`, `The server answered with status ${status}.`, "");
}

/** One sentence, a code and a hint for whatever was thrown. */
export function describe(error: unknown): {
  message: string;
  code: string;
  hint: string;
} {
  if (error instanceof ApiError) return { message: error.message, code: error.code, hint: error.hint };
  if (error instanceof Unreachable) {
    return {
      message: error.message,
      code: "unreachable",
      hint: "It may be restarting, or the network is down. This page tries again by itself.",
    };
  }
  return {
    message: error instanceof Error ? error.message : String(error),
    code: "",
    hint: "",
  };
}

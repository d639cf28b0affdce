/** One message of a `text/event-stream`. */
export interface StreamMessage {
  id: string;
  event: string;
  data: string;
}

/**
 * Parser of server-sent events (WHATWG HTML, section 9.2), fed with text as it arrives.
 *
 * The browser's own EventSource cannot send a header, and so no key.
 */
export class EventStreamParser {
  #buffer = "";
  #data: string[] = [];
  #event = "";
  #id = "";
  #started = false;
  /** Milliseconds that the server asked to wait before the next attempt. */
  retry: number | null = null;

  feed(text: string): StreamMessage[] {
    if (!this.#started && text.length > 0) {
      this.#started = true;
      if (text.startsWith("\uFEFF")) text = text.slice(1);
    }
    this.#buffer += text;
    const messages: StreamMessage[] = [];
    for (;;) {
      const end = this.#buffer.search(/[\r\n]/);
      if (end < 0) break;
      const isReturn = this.#buffer[end] === "\r";
      // A carriage return at the end of what has arrived may be half of a line's end.
      if (isReturn && end + 1 === this.#buffer.length) break;
      const line = this.#buffer.slice(0, end);
      this.#buffer = this.#buffer.slice(end + (isReturn && this.#buffer[end + 1] === "\n" ? 2 : 1));
      const message = this.#line(line);
      if (message) messages.push(message);
    }
    return messages;
  }

  #line(line: string): StreamMessage | null {
    if (line === "") {
      const message =
        this.#data.length > 0
          ? {
              id: this.#id,
              event: this.#event || "message",
              data: this.#data.join("\n"),
            }
          : null;
      this.#data = [];
      this.#event = "";
      return message;
    }
    const colon = line.indexOf(":");
    if (colon === 0) return null; // a comment, which keeps the connection alive
    const field = colon < 0 ? line : line.slice(0, colon);
    let value = colon < 0 ? "" : line.slice(colon + 1);
    if (value.startsWith(" ")) value = value.slice(1);
    if (field === "data") this.#data.push(value);
    else if (field === "event") this.#event = value;
    else if (field === "id" && !value.includes("\0")) this.#id = value;
    else if (field === "retry" && /^\d+$/.test(value)) this.retry = Number(value);
    return null;
  }
}

/** The messages of a response's body; ends when the server ends it, or when nothing came for `silence` milliseconds. */
export async function* readMessages(
  body: ReadableStream<Uint8Array>,
  silence = 60_000,
): AsyncGenerator<StreamMessage, void, undefined> {
  const parser = new EventStreamParser();
  const decoder = new TextDecoder();
  const reader = body.getReader();
  try {
    for (;;) {
      const chunk = await withTimeout(reader.read(), silence);
      if (chunk === "timeout" || chunk.done) return;
      yield* parser.feed(decoder.decode(chunk.value, { stream: true }));
    }
  } finally {
    // Whoever stops listening frees the connection: a browser has only six to a host.
    await reader.cancel().catch(() => undefined);
  }
}

async function withTimeout<T>(promise: Promise<T>, milliseconds: number): Promise<T | "timeout"> {
  let timer: ReturnType<typeof setTimeout> | undefined;
  try {
    return await Promise.race([
      promise,
      new Promise<"timeout">((resolve) => {
        timer = setTimeout(() => resolve("timeout"), milliseconds);
      }),
    ]);
  } finally {
    clearTimeout(timer);
  }
}

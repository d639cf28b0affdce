import { describe, expect, it } from "vitest";
import { EventStreamParser, readMessages } from "@/api/eventStream";

function parse(...chunks: string[]) {
  const parser = new EventStreamParser();
  return chunks.flatMap((chunk) => parser.feed(chunk));
}

describe("EventStreamParser", () => {
  const stream =
    '\uFEFF: hello\nretry: 250\n\nid: 1\nevent: state\ndata: {"a":1}\n\nid:2\r\ndata: x\r\ndata:  y\r\n\r\n';
  const expected = [
    { id: "1", event: "state", data: '{"a":1}' },
    { id: "2", event: "message", data: "x\n y" },
  ];

  it("reads fields, comments, several lines of data, and both kinds of line ends", () => {
    expect(parse(stream)).toEqual(expected);
  });

  it("reads the same however the text is cut", () => {
    for (let cut = 0; cut <= stream.length; cut += 1) {
      expect(parse(stream.slice(0, cut), stream.slice(cut))).toEqual(expected);
    }
    expect(parse(...Array.from(stream))).toEqual(expected);
  });

  it("keeps the last id, and gives no message without data", () => {
    expect(parse("id: 7\n\ndata: a\n\nevent: lonely\n\ndata\n\n")).toEqual([
      { id: "7", event: "message", data: "a" },
      { id: "7", event: "message", data: "" },
    ]);
  });

  it("does not give what has not ended", () => expect(parse("data: half\n")).toEqual([]));

  it("takes the time to wait, and nothing that is no number", () => {
    const parser = new EventStreamParser();
    parser.feed("retry: 3000\nretry: soon\n");
    expect(parser.retry).toBe(3000);
  });
});

describe("readMessages", () => {
  it("decodes letters that lie over two chunks", async () => {
    const bytes = new TextEncoder().encode("data: größer\n\n");
    const split = bytes.indexOf(0xc3) + 1;
    const body = new ReadableStream<Uint8Array>({
      start(controller) {
        controller.enqueue(bytes.slice(0, split));
        controller.enqueue(bytes.slice(split));
        controller.close();
      },
    });
    const messages = [];
    for await (const message of readMessages(body)) messages.push(message.data);
    expect(messages).toEqual(["größer"]);
  });

  it("frees the connection when nobody listens any longer", async () => {
    let cancelled = false;
    const body = new ReadableStream<Uint8Array>({
      start: (controller) => controller.enqueue(new TextEncoder().encode("data: 1\n\ndata: 2\n\n")),
      cancel: () => {
        cancelled = true;
      },
    });
    for await (const message of readMessages(body)) {
      expect(message.data).toBe("1");
      break;
    }
    expect(cancelled).toBe(true);
  });

  it("ends when the server is silent for too long", async () => {
    const body = new ReadableStream<Uint8Array>({}); // open for ever
    const messages = [];
    for await (const message of readMessages(body, 20)) messages.push(message);
    expect(messages).toEqual([]);
  });
});

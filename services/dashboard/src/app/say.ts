import { notifications } from "@mantine/notifications";
import { describe } from "@/api/problem";

/** Tell something in passing. */
export function say(title: string, message: string): void {
  notifications.show({ color: "gray", title, message, autoClose: 8_000 });
}

/** Tell in passing that an action did not work. */
export function sayFailure(title: string, error: unknown): void {
  const { message, hint } = describe(error);
  notifications.show({
    color: "red",
    title,
    message: `${message} ${hint}`.trim(),
    autoClose: 10_000,
  });
}

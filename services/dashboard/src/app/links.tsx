import { Anchor, type AnchorProps, Button, type ButtonProps } from "@mantine/core";
import { createLink } from "@tanstack/react-router";
import type { AnchorHTMLAttributes, Ref } from "react";

type LinkProps = { ref?: Ref<HTMLAnchorElement> } & Omit<AnchorHTMLAttributes<HTMLAnchorElement>, "color" | "style">;

/** Mantine's button and anchor as links of the router: typed routes, preloaded when pointed at. */
export const LinkButton = createLink((props: ButtonProps & LinkProps) => <Button component="a" {...props} />);
export const LinkAnchor = createLink((props: AnchorProps & LinkProps) => <Anchor component="a" {...props} />);

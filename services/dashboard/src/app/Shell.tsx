import {
  ActionIcon,
  Alert,
  AppShell,
  Group,
  Menu,
  Text,
  Tooltip,
  useComputedColorScheme,
  useMantineColorScheme,
} from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Link, Outlet } from "@tanstack/react-router";
import { Film, KeyRound, Layers, ListChecks, LogOut, Moon, Settings, Shapes, Sun, Upload, WifiOff } from "lucide-react";
import { connection } from "@/api/connection";
import { infoQuery } from "@/api/queries";
import { session, signOut } from "@/api/session";
import { UploadSummary } from "@/features/uploads/UploadSummary";
import { KeyGate } from "./KeyGate";
import { Logo } from "./Logo";
import classes from "./Shell.module.css";
import { useStore } from "./store";

const PAGES = [
  { to: "/upload", label: "Upload", icon: Upload },
  { to: "/jobs", label: "Jobs", icon: ListChecks },
  { to: "/batches", label: "Batches", icon: Layers },
  { to: "/shapes", label: "Shapes", icon: Shapes },
  { to: "/motion", label: "Motion", icon: Film },
] as const;

export function Shell() {
  const { refused, key } = useStore(session);
  const info = useQuery(infoQuery);
  const locked = refused || (info.data?.auth === "keys" && !key);
  return (
    <AppShell header={{ height: 56 }} padding={0}>
      <a className="skip" href="#main">
        Skip to the content
      </a>
      <AppShell.Header className={classes.header ?? ""}>
        <Group h="100%" px="lg" gap="xl" wrap="nowrap" justify="space-between">
          <Link to="/" className={classes.brand} aria-label="Shapery, to the start">
            <Logo />
            <span>Shapery</span>
          </Link>
          <Group component="nav" aria-label="Pages" gap={4} wrap="nowrap" flex={1}>
            {PAGES.map(({ to, label, icon: Icon }) => (
              <Link key={to} to={to} className={classes.page} activeProps={{ "data-active": true }}>
                <Icon size={16} aria-hidden="true" />
                {label}
              </Link>
            ))}
          </Group>
          <Group gap="xs" wrap="nowrap">
            <UploadSummary />
            {key && <KeyMenu />}
            <SettingsLink />
            <ThemeToggle />
          </Group>
        </Group>
      </AppShell.Header>
      <AppShell.Main id="main" tabIndex={-1} className={classes.main ?? ""}>
        <Silence />
        {locked ? <KeyGate refused={refused && key !== null} /> : <Outlet />}
      </AppShell.Main>
    </AppShell>
  );
}

function Silence() {
  const state = useStore(connection);
  if (state === "up") return null;
  return (
    <Alert color="orange" variant="light" icon={<WifiOff size={18} />} className={classes.silence ?? ""} role="status">
      The server does not answer. What is shown may be out of date; pages and uploads go on as soon as it is back.
    </Alert>
  );
}

function SettingsLink() {
  return (
    <Tooltip label="Keys and settings">
      <Link
        to="/settings"
        className={classes.icon}
        aria-label="Keys and settings"
        activeProps={{ "data-active": true }}
      >
        <Settings size={18} aria-hidden="true" />
      </Link>
    </Tooltip>
  );
}

function ThemeToggle() {
  const { setColorScheme } = useMantineColorScheme();
  const scheme = useComputedColorScheme("light");
  const next = scheme === "dark" ? "light" : "dark";
  return (
    <Tooltip label={`Switch to the ${next} theme`}>
      <ActionIcon
        variant="subtle"
        color="gray"
        size="lg"
        aria-label={`Switch to the ${next} theme`}
        onClick={() => setColorScheme(next)}
      >
        {scheme === "dark" ? <Sun size={18} /> : <Moon size={18} />}
      </ActionIcon>
    </Tooltip>
  );
}

function KeyMenu() {
  return (
    <Menu position="bottom-end" withArrow>
      <Menu.Target>
        <ActionIcon variant="subtle" color="gray" size="lg" aria-label="API key">
          <KeyRound size={18} />
        </ActionIcon>
      </Menu.Target>
      <Menu.Dropdown>
        <Menu.Label>
          <Text size="xs">The key is kept until this tab is closed.</Text>
        </Menu.Label>
        <Menu.Item leftSection={<LogOut size={16} />} onClick={signOut}>
          Forget the key
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}

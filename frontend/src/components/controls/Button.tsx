import type { ComponentProps } from "react";
import { Link } from "react-router";

import { classes } from "@/lib/classes";

import styles from "./Button.module.css";
import { Icon, type IconName } from "./Icon";

type ButtonKind = "primary" | "secondary" | "quiet" | "danger";

interface Look {
  kind?: ButtonKind;
  large?: boolean;
  icon?: IconName;
}

function lookOf({ kind = "secondary", large = false }: Look, extra?: string): string {
  return classes(
    styles.button,
    kind === "primary" && styles.primary,
    kind === "quiet" && styles.quiet,
    kind === "danger" && styles.danger,
    large && styles.large,
    extra,
  );
}

/** A text button, optionally with an icon. */
export function Button({
  kind,
  large,
  icon,
  className,
  children,
  ...rest
}: Look & ComponentProps<"button">) {
  return (
    <button type="button" className={lookOf({ kind, large }, className)} {...rest}>
      {icon && <Icon name={icon} />}
      {children}
    </button>
  );
}

/** A link that looks like a button. */
export function ButtonLink({
  kind,
  large,
  icon,
  className,
  children,
  ...rest
}: Look & ComponentProps<typeof Link>) {
  return (
    <Link className={lookOf({ kind, large }, className)} {...rest}>
      {icon && <Icon name={icon} />}
      {children}
    </Link>
  );
}

/** A link that looks like a button and downloads a file. */
export function DownloadLink({ children, ...rest }: ComponentProps<"a">) {
  return (
    <a className={lookOf({})} download {...rest}>
      <Icon name="download" />
      {children}
    </a>
  );
}

/** A button that shows only an icon; its label is announced and shown on hover. */
export function IconButton({
  icon,
  label,
  filled = false,
  kind = "quiet",
  className,
  ...rest
}: {
  icon: IconName;
  label: string;
  filled?: boolean;
  kind?: ButtonKind;
} & Omit<ComponentProps<"button">, "children">) {
  return (
    <button
      type="button"
      aria-label={label}
      title={label}
      className={lookOf({ kind }, classes(styles.icon, className))}
      {...rest}
    >
      <Icon name={icon} filled={filled} />
    </button>
  );
}

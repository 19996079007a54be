/PROG  SETTINGS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  UFRAME_NUM=2 ;
   2:  UTOOL_NUM=R[9] ;
   3:  PR[1]=JPOS ;
   4:  PR[2]=LPOS ;
   5:  UFRAME[2]=PR[2] ;
   6:  PR[3]=UFRAME[2] ;
   7:  R[1]=UFRAME_NUM ;
   8:  OVERRIDE=50% ;
   9:  $MCR.$GENOVERRIDE=30 ;
  10:  $WAITTMOUT=50 ;
  11:  R[2]=$WAITTMOUT ;
  12:  PAYLOAD[1] ;
  13:  LOCK PREG ;
  14:  UNLOCK PREG ;
  15:  COL DETECT ON ;
  16:  COL DETECT OFF ;
  17:  MESSAGE[part placed] ;
  18:  --eg:a remark ;
  19:  !another ;
  20:  WAIT DI[2]=ON TIMEOUT,LBL[1] ;
  21:  R[3]=1 ;
  22:  LBL[1] ;
  23:  SR[1]='a'+'b' ;
  24:  JMP LBL[2] ;
  25:  LBL[2:done] ;
/POS
/END
